// Tests of poses: node trees, visibility, instancing, cameras and lights.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/pose.h"
#include "tests/scene/scene_checks.h"

#include <gtest/gtest.h>

#include <limits>

namespace kindling {
namespace {

using test::expect_near;
using test::kHalfRoot;
using test::pose;

Node mesh_node(const V3f& translation, std::vector<int> children = {}) {
  Node node;
  node.local.translation = translation;
  node.children = std::move(children);
  node.mesh = 0;
  return node;
}

Scene scene_of(std::vector<Node> nodes, std::vector<int> roots) {
  Scene scene;
  scene.source = "test.gltf";
  Primitive triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.indices = {0, 1, 2};
  Mesh mesh;
  mesh.primitives = {triangle};
  scene.meshes = {mesh};
  scene.nodes = std::move(nodes);
  scene.scenes = {SceneRoot{"main", std::move(roots)}};
  return scene;
}

float determinant(const M44f& m) {
  const V3f x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]), z(m[2][0], m[2][1], m[2][2]);
  return x.dot(y.cross(z));
}

TEST(ToMatrix, ScalesThenRotatesThenTranslates) {
  Transform transform;
  transform.scale = {2, 3, 4};
  transform.rotation = Quatf(kHalfRoot, 0, 0, kHalfRoot); // +90 degrees about z
  transform.translation = {10, 20, 30};
  const M44f m = to_matrix(transform);
  expect_near(transform_point(m, {1, 0, 0}), {10, 22, 30}); // (2, 0, 0) rotates to (0, 2, 0)
  expect_near(transform_point(m, {0, 1, 0}), {7, 20, 30});
  expect_near(transform_point(m, {0, 0, 1}), {10, 20, 34});
  EXPECT_EQ(m[3][3], 1.0f);
}

TEST(ToMatrix, DefaultTransformIsIdentity) { EXPECT_EQ(to_matrix(Transform()), M44f()); }

// Each number is accepted by itself; the product is not.
TEST(Pose, RefusesTransformsBeyondReach) {
  const auto error_of = [](float scale, float translation) {
    Node parent;
    parent.local.scale = V3f(scale);
    parent.children = {1};
    const Result<PosedScene> posed = pose_scene(scene_of({parent, mesh_node({0, translation, 0})}, {0}), {});
    if (!posed.ok()) {
      EXPECT_EQ(posed.error().kind, ErrorKind::scene_invalid);
    }
    return posed.ok() ? "" : posed.error().message;
  };
  EXPECT_EQ(error_of(1e9f, 1e8f), "");
  EXPECT_EQ(error_of(1e12f, 1e12f), "test.gltf: /nodes/1: with those of its parents, its transform has the number "
                                    "1e+24, expected numbers from -1e+18 to 1e+18");
  EXPECT_NE(error_of(1e18f, -1e18f).find("the number -1e+36"), std::string::npos);
  EXPECT_NE(error_of(std::numeric_limits<float>::infinity(), 1.0f), "");
  EXPECT_NE(error_of(std::numeric_limits<float>::quiet_NaN(), 1.0f), "");
}

TEST(Pose, ChildrenInheritParentTransforms) {
  Node parent = mesh_node({1, 0, 0}, {1});
  parent.local.rotation = Quatf(kHalfRoot, 0, 0, kHalfRoot);
  parent.local.scale = {2, 2, 2};
  Node child = mesh_node({1, 0, 0}, {2});
  child.local.scale = {1, -1, 1}; // mirrored
  Node grandchild;
  grandchild.mesh = 0;
  grandchild.matrix = M44f(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1); // glTF's memory order: translation last
  const PosedScene posed = pose(scene_of({parent, child, grandchild}, {0}));
  ASSERT_EQ(posed.meshes.size(), 3u);
  expect_near(transform_point(posed.meshes[0].mesh_to_world, {1, 0, 0}), {1, 2, 0});
  expect_near(transform_point(posed.meshes[1].mesh_to_world, {0, 0, 0}), {1, 2, 0});
  expect_near(transform_point(posed.meshes[1].mesh_to_world, {0, 1, 0}), {3, 2, 0}); // -y, doubled, rotated to +x
  expect_near(transform_point(posed.meshes[2].mesh_to_world, {0, 0, 0}), {11, 2, 0});
  EXPECT_GT(determinant(posed.meshes[0].mesh_to_world), 0.0f);
  EXPECT_LT(determinant(posed.meshes[1].mesh_to_world), 0.0f);
  EXPECT_TRUE(posed.meshes[0].deformed.empty());
}

TEST(Pose, ListsMeshesInTreeOrder) {
  // 4 is the first root; 0 has children 3 and 1, and 3 has child 2.
  const Scene scene = scene_of({mesh_node({0, 0, 0}, {3, 1}), mesh_node({0, 0, 0}), mesh_node({0, 0, 0}),
                                mesh_node({0, 0, 0}, {2}), mesh_node({0, 0, 0})},
                               {4, 0});
  const PosedScene posed = pose(scene);
  std::vector<int> order;
  for (const PosedMesh& mesh : posed.meshes) order.push_back(mesh.node);
  EXPECT_EQ(order, (std::vector<int>{4, 0, 3, 2, 1}));
}

TEST(Pose, DeepTreeDoesNotOverflowStack) {
  constexpr int kDepth = 300000;
  std::vector<Node> nodes(kDepth);
  for (int i = 0; i + 1 < kDepth; ++i) nodes[static_cast<size_t>(i)].children = {i + 1};
  nodes.front().local.translation = {0, 0, 7};
  nodes.back().mesh = 0;
  const PosedScene posed = pose(scene_of(std::move(nodes), {0}));
  ASSERT_EQ(posed.meshes.size(), 1u);
  expect_near(transform_point(posed.meshes[0].mesh_to_world, {0, 0, 0}), {0, 0, 7});
}

TEST(Pose, SelectsRequestedScene) {
  Scene scene = scene_of({mesh_node({0, 0, 0}), mesh_node({1, 0, 0}), mesh_node({2, 0, 0})}, {0});
  scene.scenes.push_back({"other", {1, 2}});
  EXPECT_EQ(pose(scene).meshes.size(), 1u); // no default: the first
  scene.default_scene = 1;
  EXPECT_EQ(pose(scene).meshes.size(), 2u);
  EXPECT_EQ(pose(scene, {.scene = 0}).meshes[0].node, 0);
  scene.scenes.clear();
  scene.default_scene = kNone;
  EXPECT_EQ(pose(scene).meshes.size(), 3u); // no scenes: everything
}

TEST(Pose, ErrorListsExistingScenes) {
  Scene scene = scene_of({mesh_node({0, 0, 0})}, {0});
  scene.scenes.push_back({"", {0}});
  const Result<PosedScene> posed = pose_scene(scene, {.scene = 7});
  ASSERT_FALSE(posed.ok());
  EXPECT_EQ(posed.error().kind, ErrorKind::usage);
  EXPECT_EQ(posed.error().message, "test.gltf: scene 7 does not exist; use 0 'main' or 1");
  EXPECT_FALSE(pose_scene(scene, {.scene = -2}).ok());
}

TEST(Pose, HiddenNodesHideDescendantsExceptCameras) {
  Node hidden = mesh_node({0, 0, 0}, {1});
  hidden.visible = false;
  hidden.light = 0;
  hidden.camera = 0;
  Node below = mesh_node({0, 0, 0});
  Node beside = mesh_node({0, 0, 0});
  beside.light = 0;
  Scene scene = scene_of({hidden, below, beside}, {0, 2});
  scene.lights = {PunctualLight()};
  scene.cameras = {SceneCamera()};
  const PosedScene posed = pose(scene);
  ASSERT_EQ(posed.meshes.size(), 1u);
  EXPECT_EQ(posed.meshes[0].node, 2);
  ASSERT_EQ(posed.lights.size(), 1u);
  EXPECT_EQ(posed.lights[0].node, 2);
  EXPECT_EQ(posed.cameras.size(), 1u); // KHR_node_visibility: cameras are not affected
}

TEST(Pose, VisibilityCanBeAnimated) {
  Scene scene = scene_of({mesh_node({0, 0, 0})}, {0});
  AnimationChannel channel;
  channel.node = 0;
  channel.property = AnimatedProperty::visible;
  channel.interpolation = Interpolation::step;
  channel.components = 1;
  channel.times_s = {0, 1};
  channel.values = {0, 1};
  scene.animations = {Animation{"blink", {channel}}};
  EXPECT_EQ(pose(scene).meshes.size(), 1u); // rest pose
  EXPECT_EQ(pose(scene, {.time_s = 0.5}).meshes.size(), 0u);
  EXPECT_EQ(pose(scene, {.time_s = 1.5}).meshes.size(), 1u);
}

TEST(Pose, AppliesAnimationsOnlyWithTime) {
  Scene scene = scene_of({mesh_node({1, 2, 3})}, {0});
  AnimationChannel move;
  move.node = 0;
  move.times_s = {0, 1};
  move.values = {0, 0, 0, 10, 0, 0};
  AnimationChannel grow = move;
  grow.property = AnimatedProperty::scale;
  grow.values = {1, 1, 1, 3, 3, 3};
  AnimationChannel turn = move;
  turn.property = AnimatedProperty::rotation;
  turn.components = 4;
  turn.values = {0, 0, 0, 1, 0, 0, kHalfRoot, kHalfRoot};
  scene.animations = {Animation{"a", {move}}, Animation{"b", {grow, turn}}};
  expect_near(transform_point(pose(scene).meshes[0].mesh_to_world, {1, 0, 0}), {2, 2, 3});
  const float diagonal = 2.0f * kHalfRoot; // scale 2, 45 degrees about z
  expect_near(transform_point(pose(scene, {.time_s = 0.5}).meshes[0].mesh_to_world, {1, 0, 0}),
              {5 + diagonal, diagonal, 0});
}

TEST(Pose, GpuInstancesRepeatMesh) {
  Node node = mesh_node({0, 0, 5});
  Transform a, b;
  a.translation = {1, 0, 0};
  b.scale = {2, 2, 2};
  node.gpu_instances = {a, b};
  node.local.scale = {3, 3, 3};
  const PosedScene posed = pose(scene_of({node}, {0}));
  ASSERT_EQ(posed.meshes.size(), 2u);
  expect_near(transform_point(posed.meshes[0].mesh_to_world, {1, 0, 0}), {6, 0, 5});
  expect_near(transform_point(posed.meshes[1].mesh_to_world, {1, 0, 0}), {6, 0, 5});
  expect_near(transform_point(posed.meshes[1].mesh_to_world, {0, 1, 0}), {0, 6, 5});
}

TEST(Pose, CamerasAndLightsAreRigid) {
  Node parent;
  parent.local.scale = {-2, 3, 0.5f};
  parent.children = {1};
  Node node;
  node.camera = 0;
  node.light = 0;
  node.local.translation = {1, 1, 1};
  node.local.rotation = Quatf(kHalfRoot, 0, kHalfRoot, 0); // +90 degrees about y: looks along -x
  Scene scene = scene_of({parent, node}, {0});
  scene.cameras = {SceneCamera()};
  scene.lights = {PunctualLight()};
  const PosedScene posed = pose(scene);
  const M44f& m = posed.cameras.at(0).camera_to_world;
  EXPECT_EQ(posed.lights.at(0).light_to_world, m);
  EXPECT_NEAR(determinant(m), 1.0f, 1e-5f);
  expect_near(transform_point(m, {0, 0, 0}), {-2, 3, 0.5f});
  expect_near(transform_vector(m, {0, 0, -1}), {1, 0, 0}); // mirrored in x by the parent
  expect_near(transform_vector(m, {0, 1, 0}), {0, 1, 0});
}

TEST(Pose, CameraWithZeroScaleHasValidFrame) {
  for (const V3f& scale : {V3f(0, 0, 0), V3f(1, 0, 1), V3f(1, 1, 0), V3f(0, 1, 0)}) {
    Node node;
    node.camera = 0;
    node.local.scale = scale;
    Scene scene = scene_of({node}, {0});
    scene.cameras = {SceneCamera()};
    const M44f m = pose(scene).cameras.at(0).camera_to_world;
    EXPECT_NEAR(determinant(m), 1.0f, 1e-5f) << scale;
  }
}

} // namespace
} // namespace kindling
