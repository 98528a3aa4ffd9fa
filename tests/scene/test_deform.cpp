// Tests of skins and morph targets against hand-computed vertices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/pose.h"
#include "tests/scene/scene_checks.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

namespace kindling {
namespace {

using test::expect_near;
using test::kHalfRoot;
using test::pose;
using test::xyz;

// A bar along y with a joint at its foot (node 1) and one at y = 1 (node 2, child of 1). Node 0
// holds the mesh, far away.
Scene two_joints() {
  Primitive bar;
  bar.positions = {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}};
  bar.normals = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  bar.tangents = {{0, 1, 0, 1}, {0, 1, 0, 1}, {0, 1, 0, -1}};
  bar.indices = {0, 1, 2};
  bar.joints = {{0, 1, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0}};
  bar.weights = {{1, 0, 0, 0}, {0.5f, 0.5f, 0, 0}, {0, 1, 0, 0}};
  Mesh mesh;
  mesh.primitives = {bar};

  Node holder;
  holder.mesh = 0;
  holder.skin = 0;
  holder.local.translation = {1000, 1000, 1000};
  Node foot;
  foot.children = {2};
  Node top;
  top.local.translation = {0, 1, 0};

  Scene scene;
  scene.meshes = {mesh};
  scene.nodes = {holder, foot, top};
  scene.scenes = {SceneRoot{"", {0, 1}}};
  Skin skin;
  skin.joints = {1, 2};
  skin.inverse_bind_matrices = {M44f(), M44f(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1)};
  scene.skins = {skin};
  return scene;
}

TEST(Skin, BindPoseIsIdentityAndIgnoresNodeTransform) {
  const PosedScene posed = pose(two_joints());
  ASSERT_EQ(posed.meshes.size(), 1u);
  EXPECT_EQ(posed.meshes[0].mesh_to_world, M44f());
  ASSERT_EQ(posed.meshes[0].deformed.size(), 1u);
  const PosedMesh::Deformed& bar = posed.meshes[0].deformed[0];
  for (int v = 0; v < 3; ++v) {
    expect_near(bar.positions[static_cast<size_t>(v)], V3f(0, static_cast<float>(v), 0));
    expect_near(bar.normals[static_cast<size_t>(v)], {1, 0, 0});
  }
}

TEST(Skin, BlendsTwoJoints) {
  Scene scene = two_joints();
  scene.nodes[2].local.rotation = Quatf(kHalfRoot, 0, 0, kHalfRoot); // the top joint rotates by 90 degrees about z
  scene.nodes[1].local.translation = {0, 0, 3};                      // and both move along z
  const PosedMesh::Deformed bar = pose(scene).meshes.at(0).deformed.at(0);
  expect_near(bar.positions[0], {0, 0, 3});
  expect_near(bar.positions[1], {0, 1, 3});  // weighted by both joints
  expect_near(bar.positions[2], {-1, 1, 3}); // one above the joint: rotated from +y to -x
  expect_near(bar.normals[0], {1, 0, 0});
  expect_near(bar.normals[1], {kHalfRoot, kHalfRoot, 0}); // half of a right angle
  expect_near(bar.normals[2], {0, 1, 0});
  expect_near(xyz(bar.tangents[2]), {-1, 0, 0});
  EXPECT_EQ(bar.tangents[0].w, 1.0f);
  EXPECT_EQ(bar.tangents[2].w, -1.0f);
}

TEST(Skin, NormalsUseInverseTranspose) {
  Scene scene = two_joints();
  scene.meshes[0].primitives[0].normals.assign(3, V3f(kHalfRoot, kHalfRoot, 0));
  scene.meshes[0].primitives[0].tangents.assign(3, V4f(-kHalfRoot, kHalfRoot, 0, 1));
  scene.nodes[1].local.scale = {2, 1, 1};
  scene.nodes[2].local.scale = {1, 1, 1};
  const PosedMesh::Deformed bar = pose(scene).meshes.at(0).deformed.at(0);
  // The plane x + y = 0 becomes x / 2 + y = 0.
  expect_near(bar.normals[0], V3f(0.5f, 1, 0).normalized());
  expect_near(xyz(bar.tangents[0]), V3f(-2, 1, 0).normalized());
}

TEST(Skin, MirroringFlipsBitangentSign) {
  Scene scene = two_joints();
  scene.nodes[1].local.scale = {-1, 1, 1};
  const PosedMesh::Deformed bar = pose(scene).meshes.at(0).deformed.at(0);
  expect_near(bar.normals[0], {-1, 0, 0});
  EXPECT_EQ(bar.tangents[0].w, -1.0f);
  // The bitangent is mirrored like any vector: cross(x, y) = z is unchanged.
  expect_near(bar.normals[0].cross(xyz(bar.tangents[0])) * bar.tangents[0].w, {0, 0, 1});
}

TEST(Skin, BlendsMoreThanFourInfluences) {
  Scene scene = two_joints();
  Primitive& bar = scene.meshes[0].primitives[0];
  // A second set of joints moves half of every vertex's weight to joint 1.
  bar.joints.insert(bar.joints.end(), 3, {1, 0, 0, 0});
  for (V4f& w : bar.weights) w *= 0.5f;
  bar.weights.insert(bar.weights.end(), 3, V4f(0.5f, 0, 0, 0));
  scene.nodes[2].local.translation = {4, 1, 0};
  const PosedMesh::Deformed posed = pose(scene).meshes.at(0).deformed.at(0);
  expect_near(posed.positions[0], {2, 0, 0});
  expect_near(posed.positions[1], {3, 1, 0});
  expect_near(posed.positions[2], {4, 2, 0});
}

TEST(Skin, FlattenedJointsGiveFiniteNormals) {
  Scene scene = two_joints();
  scene.nodes[1].local.scale = {0, 0, 0};
  const PosedMesh::Deformed bar = pose(scene).meshes.at(0).deformed.at(0);
  for (size_t v = 0; v < 3; ++v) {
    EXPECT_NEAR(bar.normals[v].length(), 1.0f, 1e-5f);
    EXPECT_NEAR(xyz(bar.tangents[v]).length(), 1.0f, 1e-5f);
  }
}

// One triangle with two targets: the first lifts vertex 0 and tilts its normal, the second
// translates everything along x.
Scene morphing() {
  Primitive triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.normals.assign(3, V3f(0, 0, 1));
  triangle.tangents.assign(3, V4f(1, 0, 0, -1));
  triangle.indices = {0, 1, 2};
  MorphTarget lift;
  lift.positions = {{0, 0, 2}, {0, 0, 0}, {0, 0, 0}};
  lift.normals = {{1, 0, -1}, {0, 0, 0}, {0, 0, 0}};
  MorphTarget slide;
  slide.positions.assign(3, V3f(1, 0, 0));
  triangle.targets = {lift, slide};
  Primitive still; // a primitive of the same mesh without targets
  still.positions = {{5, 5, 5}, {6, 5, 5}, {5, 6, 5}};
  still.indices = {0, 1, 2};
  Mesh mesh;
  mesh.primitives = {triangle, still};
  mesh.weights = {0, 0};
  Node node;
  node.mesh = 0;
  node.local.translation = {0, 0, 9};
  Scene scene;
  scene.meshes = {mesh};
  scene.nodes = {node};
  scene.scenes = {SceneRoot{"", {0}}};
  return scene;
}

TEST(Morph, ZeroWeightsShareSceneVertices) { EXPECT_TRUE(pose(morphing()).meshes.at(0).deformed.empty()); }

TEST(Morph, AddsWeightedDeltasInMeshSpace) {
  Scene scene = morphing();
  scene.meshes[0].weights = {0.5f, 3};
  const PosedScene posed = pose(scene);
  const PosedMesh& mesh = posed.meshes.at(0);
  expect_near(transform_point(mesh.mesh_to_world, {0, 0, 0}), {0, 0, 9});
  ASSERT_EQ(mesh.deformed.size(), 2u);
  expect_near(mesh.deformed[0].positions[0], {3, 0, 1});
  expect_near(mesh.deformed[0].positions[1], {4, 0, 0});
  expect_near(mesh.deformed[0].normals[0], {kHalfRoot, 0, kHalfRoot}); // (0.5, 0, 0.5), unit
  expect_near(mesh.deformed[0].normals[1], {0, 0, 1});
  // The tangent has no deltas and stays orthogonal to the tilted normal.
  expect_near(xyz(mesh.deformed[0].tangents[0]), {kHalfRoot, 0, -kHalfRoot});
  EXPECT_EQ(mesh.deformed[0].tangents[0].w, -1.0f);
  expect_near(mesh.deformed[1].positions[0], {5, 5, 5});
  EXPECT_TRUE(mesh.deformed[1].normals.empty());
}

TEST(Morph, WeightPrecedenceIsAnimationNodeMesh) {
  Scene scene = morphing();
  scene.meshes[0].weights = {1, 0};
  scene.nodes[0].weights = {0, 1};
  expect_near(pose(scene).meshes.at(0).deformed.at(0).positions[0], {1, 0, 0});
  AnimationChannel channel;
  channel.node = 0;
  channel.property = AnimatedProperty::weights;
  channel.components = 2;
  channel.times_s = {0, 1};
  channel.values = {0, 0, 1, 4};
  scene.animations = {Animation{"", {channel}}};
  expect_near(pose(scene, {.time_s = 0.5}).meshes.at(0).deformed.at(0).positions[0], {2, 0, 1});
}

TEST(Morph, IsAppliedBeforeSkin) {
  Scene scene = two_joints();
  MorphTarget target;
  target.positions.assign(3, V3f(1, 0, 0));
  scene.meshes[0].primitives[0].targets = {target};
  scene.meshes[0].weights = {1};
  scene.nodes[1].local.rotation = Quatf(kHalfRoot, 0, 0, kHalfRoot);
  const PosedMesh::Deformed bar = pose(scene).meshes.at(0).deformed.at(0);
  expect_near(bar.positions[0], {0, 1, 0}); // moved along x, then rotated
  expect_near(bar.positions[2], {-2, 1, 0});
}

TEST(Deform, IsIndependentOfThreadCount) {
  Scene scene = two_joints();
  Primitive& bar = scene.meshes[0].primitives[0];
  constexpr size_t kVertices = 100000;
  bar = {};
  for (size_t v = 0; v < kVertices; ++v) {
    const float x = static_cast<float>(v % 977) / 977.0f;
    bar.positions.push_back({x, static_cast<float>(v % 311) / 100.0f, 1.0f - x});
    bar.normals.push_back(V3f(x, 1, 0.5f).normalized());
    bar.joints.push_back({0, 1, 0, 0});
    bar.weights.push_back({x, 1.0f - x, 0, 0});
  }
  bar.indices = {0, 1, 2};
  scene.nodes[2].local.rotation = Quatf(0.8f, 0.6f, 0, 0);
  const auto run = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return pose(scene).meshes.at(0).deformed.at(0);
  };
  const PosedMesh::Deformed one = run(1), four = run(4);
  EXPECT_EQ(one.positions, four.positions);
  EXPECT_EQ(one.normals, four.normals);
}

} // namespace
} // namespace kindling
