// Tests of world bounds and scene statistics.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/bounds.h"
#include "renderer/scene/describe.h"
#include "tests/scene/scene_checks.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::kHalfRoot;
using test::pose;

Scene one_triangle() {
  Primitive triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {100, 100, 100}}; // the last vertex is unused
  triangle.indices = {0, 1, 2};
  triangle.texcoords = {std::vector<V2f>(4)};
  triangle.targets.resize(1);
  triangle.targets[0].positions = {{0, 0, 5}, {0, 0, 5}, {0, 0, 5}, {0, 0, 5}};
  Mesh mesh;
  mesh.primitives = {triangle};
  Node node;
  node.mesh = 0;
  Scene scene;
  scene.meshes = {mesh};
  scene.nodes = {node};
  scene.scenes = {SceneRoot{"", {0}}};
  return scene;
}

TEST(WorldBounds, AreTightAroundTransformedVertices) {
  Scene scene = one_triangle();
  scene.nodes[0].local.rotation = Quatf(std::cos(kPi / 8), 0, 0, std::sin(kPi / 8)); // 45 degrees about z
  scene.nodes[0].local.translation = {10, 0, 0};
  const Box3f box = world_bounds(scene, pose(scene));
  EXPECT_NEAR(box.min.x, 10 - kHalfRoot, 1e-5f); // the box of the rotated box would be larger
  EXPECT_NEAR(box.max.x, 10 + kHalfRoot, 1e-5f);
  EXPECT_NEAR(box.min.y, 0, 1e-5f);
  EXPECT_NEAR(box.max.y, kHalfRoot, 1e-5f);
  EXPECT_EQ(box.min.z, 0.0f);
  EXPECT_EQ(box.max.z, 0.0f);
}

TEST(WorldBounds, IncludeDeformedVertices) {
  Scene scene = one_triangle();
  scene.meshes[0].weights = {1};
  EXPECT_EQ(world_bounds(scene, pose(scene)), Box3f({0, 0, 5}, {1, 1, 5}));
}

TEST(WorldBounds, AreEmptyWithoutTriangles) {
  Scene scene = one_triangle();
  scene.nodes[0].visible = false;
  EXPECT_TRUE(world_bounds(scene, pose(scene)).isEmpty());
}

TEST(WorldBounds, FallBackToBoxesForManyInstances) {
  // 300 instances of 500000 corners each exceed 2^27 corners.
  Scene scene = one_triangle();
  Primitive& primitive = scene.meshes[0].primitives[0];
  primitive.indices.resize(500001, 1);
  primitive.indices[0] = 0;
  primitive.indices[2] = 2;
  for (int i = 0; i < 300; ++i) {
    Transform instance;
    instance.translation = {static_cast<float>(i), 0, 0};
    scene.nodes[0].gpu_instances.push_back(instance);
  }
  EXPECT_EQ(world_bounds(scene, pose(scene)), Box3f({0, 0, 0}, {300, 1, 0}));
}

TEST(Describe, CountsEachThingOnce) {
  Scene scene = one_triangle();
  scene.nodes.push_back(scene.nodes[0]);
  scene.scenes[0].nodes = {0, 1};
  const auto image = std::make_shared<Image>(Image{4, 2, 3, PixelType::u16, {}});
  scene.textures.resize(3);
  scene.textures[0].image = scene.textures[1].image = image;
  AnimationChannel channel;
  channel.node = 0;
  channel.times_s = {0.5f, 2.0f};
  channel.values.resize(6);
  scene.animations = {Animation{"", {channel, channel}}};
  Skin skin;
  skin.joints = {0, 1};
  scene.skins = {skin};

  const SceneStatistics found = describe(scene);
  EXPECT_EQ(found.meshes, 1u);
  EXPECT_EQ(found.nodes, 2u);
  EXPECT_EQ(found.primitives, 1u);
  EXPECT_EQ(found.triangles, 1u);
  EXPECT_EQ(found.vertices, 4u);
  EXPECT_EQ(found.geometry_bytes, 3 * 4 + 4 * (12 + 8 + 12)); // indices; position, uv and target of each vertex
  EXPECT_EQ(found.textures, 3u);
  EXPECT_EQ(found.images, 1u);
  EXPECT_EQ(found.unreadable_textures, 1u);
  EXPECT_EQ(found.texture_bytes, 4u * 2 * 3 * 2);
  EXPECT_EQ(found.morph_targets, 1u);
  EXPECT_EQ(found.animation_channels, 2u);
  EXPECT_EQ(found.first_key_s, 0.5);
  EXPECT_EQ(found.last_key_s, 2.0);
  EXPECT_EQ(found.joints, 2u);

  scene.nodes[1].weights = {0.5f};
  const PosedStatistics posed = describe(scene, pose(scene));
  EXPECT_EQ(posed.mesh_instances, 2u);
  EXPECT_EQ(posed.distinct_meshes, 1u);
  EXPECT_EQ(posed.triangles, 2u);
  EXPECT_EQ(posed.deformed_meshes, 1u);
  EXPECT_EQ(posed.deformed_bytes, 4u * 12);
}

TEST(Describe, EmptySceneHasNoKeys) {
  const SceneStatistics found = describe(Scene());
  EXPECT_FALSE(found.first_key_s.has_value());
  EXPECT_EQ(found.triangles, 0u);
}

} // namespace
} // namespace kindling
