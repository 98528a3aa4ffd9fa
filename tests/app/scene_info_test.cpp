// The contents of a scene in `kindling info`.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/info/scene_info.h"

#include <gtest/gtest.h>

namespace kindling::app {
namespace {

TEST(SceneInfo, ListsLightsOfAllKinds) {
  Scene scene;
  PunctualLight spot;
  spot.name = "spot";
  spot.kind = PunctualLight::Kind::spot;
  spot.intensity = 30.0f;
  PunctualLight luminaire;
  luminaire.name = "luminaire";
  luminaire.photometry = 0;
  luminaire.intensity = 2.0f;
  scene.lights = {spot, luminaire};
  scene.photometries.emplace_back();
  for (const char* name : {"dawn", "noon"}) {
    ImageLight sky;
    sky.name = name;
    sky.intensity = 0.5f;
    scene.image_lights.push_back(sky);
  }
  Node node;
  node.light = 0;
  scene.nodes.push_back(node);
  SceneRoot root;
  root.nodes = {0};
  root.image_light = 1;
  scene.scenes.push_back(root);
  const Result<PosedScene> posed = pose_scene(scene, {});
  ASSERT_TRUE(posed.ok());

  const SceneInfo info = collect_scene_info(scene, posed.value(), 0);
  const auto expect = [&](size_t i, const char* name, const char* kind, const char* intensity, uint64_t placed) {
    EXPECT_EQ(info.lights.at(i).name, name);
    EXPECT_EQ(info.lights[i].kind, kind);
    EXPECT_EQ(info.lights[i].intensity, intensity);
    EXPECT_EQ(info.lights[i].placed, placed);
  };
  ASSERT_EQ(info.lights.size(), 4U);
  expect(0, "spot", "spot", "30 candela", 1);
  expect(1, "luminaire", "photometric", "x 2", 0);
  expect(2, "dawn", "image-based", "x 0.5", 0);
  expect(3, "noon", "image-based", "x 0.5", 1);
}

} // namespace
} // namespace kindling::app
