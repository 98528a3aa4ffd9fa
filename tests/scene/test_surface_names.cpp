// Names of objects and materials are there and unique; roots are the nodes above all.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/surface_names.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using Words = std::vector<std::string>;

TEST(SurfaceNames, AreUnique) {
  Scene scene;
  scene.meshes = {{.name = "Chair"}, {}};
  for (const char* name : {"Leg", "Leg", "", "", "Leg.001", "Leg", "Chair"}) scene.nodes.push_back({.name = name});
  scene.nodes[2].mesh = 0;
  scene.nodes[3].mesh = 1;
  for (const char* name : {"", "wood", "wood", "default"}) scene.materials.push_back({.name = name});
  const SurfaceNames names = name_surfaces(scene);
  EXPECT_EQ(names.nodes, (Words{"Leg", "Leg.001", "Chair", "Node_3", "Leg.001.001", "Leg.002", "Chair.001"}));
  EXPECT_EQ(names.materials, (Words{"Material_0", "wood", "wood.001", "default", "default.001"}));
  EXPECT_EQ(names.has_mesh, (std::vector<uint8_t>{0, 0, 1, 1, 0, 0, 0}));
}

TEST(SurfaceNames, RootsAreTheNodesWithoutParents) {
  Scene scene;
  scene.nodes.resize(6);
  scene.nodes[3].children = {1};
  scene.nodes[1].children = {0, 4};
  scene.nodes[2].children = {5};
  EXPECT_EQ(name_surfaces(scene).roots, (std::vector<int>{3, 3, 2, 3, 3, 2}));
}

TEST(SurfaceNames, AreUniqueAmongManyEqualOnes) {
  Scene scene;
  for (int i = 0; i < 20000; ++i) scene.nodes.push_back({.name = "Leaf"});
  for (int i = 0; i + 1 < 20000; ++i) scene.nodes[static_cast<size_t>(i)].children = {i + 1}; // one long chain
  const SurfaceNames names = name_surfaces(scene);
  EXPECT_EQ(names.nodes.back(), "Leaf.19999");
  EXPECT_EQ(names.roots, std::vector<int>(20000, 0));
}

} // namespace
} // namespace kindling
