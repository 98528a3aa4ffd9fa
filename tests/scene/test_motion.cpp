// Tests of motion keys over the shutter against poses at the times between them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/bounds.h"
#include "renderer/scene/pose.h"
#include "tests/scene/scene_checks.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>

#include <cmath>

namespace kindling {
namespace {

using test::kHalfRoot;
using test::pose;

AnimationChannel channel_of(int node, AnimatedProperty property, std::vector<float> times, std::vector<float> values) {
  AnimationChannel channel;
  channel.node = node;
  channel.property = property;
  channel.components = static_cast<int>(values.size() / times.size());
  channel.times_s = std::move(times);
  channel.values = std::move(values);
  return channel;
}

// One rotation of 90 degrees about z in each second, from time 0 to 4.
AnimationChannel turn(int node) {
  return channel_of(node, AnimatedProperty::rotation, {0, 1, 2, 3, 4},
                    {0, 0, 0, 1, 0, 0, kHalfRoot, kHalfRoot, 0, 0, 1, 0, 0, 0, kHalfRoot, -kHalfRoot, 0, 0, 0, -1});
}

// Two nodes below a parent, each with a mesh: a square of radius 1 in the parent's origin and one 3
// m away from it.
Scene two_squares() {
  Scene scene;
  scene.source = "test.gltf";
  Primitive square;
  square.positions = {
      {-kHalfRoot, -kHalfRoot, 0}, {kHalfRoot, -kHalfRoot, 0}, {kHalfRoot, kHalfRoot, 0}, {-kHalfRoot, kHalfRoot, 0}};
  square.indices = {0, 1, 2, 0, 2, 3};
  scene.meshes = {Mesh{.primitives = {square}}};
  Node parent, near, far;
  parent.children = {1, 2};
  near.mesh = far.mesh = 0;
  far.local.translation = {3, 0, 0};
  scene.nodes = {parent, near, far};
  scene.scenes = {SceneRoot{"main", {0}}};
  return scene;
}

PosedScene pose(const Scene& scene, double open_s, double close_s) {
  return pose(scene, {.shutter = Shutter{open_s, close_s}});
}

// Interpolates the two keys around `fraction` of the shutter.
template <typename T, typename At>
T between(size_t key_count, double fraction, const At& at) {
  const double position = fraction * static_cast<double>(key_count - 1);
  const size_t key = std::min(static_cast<size_t>(position), key_count - 2);
  const auto t = static_cast<float>(position - static_cast<double>(key));
  return at(key) * (1.0f - t) + at(key + 1) * t;
}

M44f matrix_at(const PosedMesh& mesh, double fraction) {
  if (mesh.later_transforms.empty()) return mesh.mesh_to_world;
  return between<M44f>(mesh.later_transforms.size() + 1, fraction,
                       [&](size_t key) { return key == 0 ? mesh.mesh_to_world : mesh.later_transforms[key - 1]; });
}

V3f vertex_at(const PosedMesh& mesh, size_t primitive, size_t vertex, double fraction) {
  if (mesh.later_deformed.empty()) return mesh.deformed[primitive].positions[vertex];
  return between<V3f>(mesh.later_deformed.size() + 1, fraction, [&](size_t key) {
    return (key == 0 ? mesh.deformed : mesh.later_deformed[key - 1])[primitive].positions[vertex];
  });
}

// Compares the corners of undeformed meshes at many times with poses at those times.
void expect_matches_poses(const Scene& scene, const Shutter& shutter, float tolerance_m) {
  const PosedScene moving = pose(scene, {.shutter = shutter});
  for (int i = 0; i <= 97; ++i) {
    const double fraction = i / 97.0;
    const PosedScene still = pose(scene, {.time_s = shutter.open_s + (shutter.close_s - shutter.open_s) * fraction});
    ASSERT_EQ(still.meshes.size(), moving.meshes.size());
    for (size_t m = 0; m < still.meshes.size(); ++m) {
      const M44f found = matrix_at(moving.meshes[m], fraction);
      for (const V3f& p : scene.meshes[static_cast<size_t>(still.meshes[m].mesh)].primitives[0].positions) {
        const float off = (transform_point(found, p) - transform_point(still.meshes[m].mesh_to_world, p)).length();
        EXPECT_LT(off, tolerance_m) << "mesh " << m << " at " << fraction;
      }
    }
  }
}

size_t keys_of(const PosedMesh& mesh) { return 1 + mesh.later_transforms.size() + mesh.later_deformed.size(); }

TEST(Motion, ZeroLengthShutterEqualsPose) {
  Scene scene = two_squares();
  scene.animations = {{"", {turn(0)}}};
  const PosedScene frozen = pose(scene, 0.3, 0.3);
  const PosedScene posed = pose(scene, {.time_s = 0.3});
  for (size_t i = 0; i < posed.meshes.size(); ++i) {
    EXPECT_EQ(frozen.meshes[i].mesh_to_world, posed.meshes[i].mesh_to_world);
    EXPECT_EQ(keys_of(frozen.meshes[i]), 1u);
  }
}

TEST(Motion, StaticNodeHasOneKey) {
  Scene scene = two_squares();
  // Keyframes with constant values, and a motion that ends before the shutter opens.
  scene.animations = {
      {"",
       {channel_of(1, AnimatedProperty::rotation, {0, 1, 5}, {0.6f, 0, 0, 0.8f, 0.6f, 0, 0, 0.8f, 0.6f, 0, 0, 0.8f}),
        channel_of(2, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 5, 0, 0})}}};
  for (const PosedMesh& mesh : pose(scene, 2.0, 3.0).meshes) EXPECT_EQ(keys_of(mesh), 1u);
  EXPECT_EQ(keys_of(pose(scene, 0.5, 0.6).meshes[1]), 2u);
}

// A node that leaves the reach of the accelerators while the shutter is open: with a rigid and with
// a deforming mesh.
TEST(Motion, RefusesLaterKeysBeyondReach) {
  for (const bool deforming : {false, true}) {
    Scene scene = two_squares();
    scene.nodes[0].local.scale = V3f(1e12f);
    scene.animations = {{"", {channel_of(2, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 1e8f, 0, 0})}}};
    if (deforming) {
      scene.meshes[0].weights = {0};
      scene.meshes[0].primitives[0].targets = {MorphTarget{.positions = std::vector<V3f>(4, V3f(0, 0, 1))}};
      scene.animations[0].channels.push_back(channel_of(2, AnimatedProperty::weights, {0, 1}, {0, 1}));
    }
    EXPECT_TRUE(pose_scene(scene, {.shutter = Shutter{0.0, 0.005}}).ok()) << "5e17";
    EXPECT_TRUE(pose_scene(scene, {.time_s = 0.0}).ok());
    const Result<PosedScene> posed = pose_scene(scene, {.shutter = Shutter{0.0, 1.0}});
    ASSERT_FALSE(posed.ok()) << deforming;
    EXPECT_EQ(posed.error().kind, ErrorKind::scene_invalid);
    EXPECT_NE(
        posed.error().message.find("test.gltf: /nodes/2: with those of its parents, its transform has the number "),
        std::string::npos)
        << posed.error().message;
  }
}

TEST(Motion, StraightTranslationHasTwoKeys) {
  Scene scene = two_squares();
  scene.animations = {{"", {channel_of(2, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 500, 0, 0})}}};
  const PosedScene posed = pose(scene, 0.25, 0.75);
  EXPECT_EQ(keys_of(posed.meshes[0]), 1u);
  ASSERT_EQ(keys_of(posed.meshes[1]), 2u);
  EXPECT_EQ(transform_point(posed.meshes[1].mesh_to_world, V3f(0)), V3f(125, 0, 0));
  EXPECT_EQ(transform_point(posed.meshes[1].later_transforms[0], V3f(0)), V3f(375, 0, 0));
}

// A chord of an arc of 90 degrees / n is off by radius (1 - cos(45 / n)): below 1e-3 of the radius
// from n = 18 on. The far mesh has a box of radius 1, and its farthest corner moves on a circle of
// 3.77 m.
TEST(Motion, KeyCountOfRotationGrowsWithRadius) {
  Scene scene = two_squares();
  scene.animations = {{"", {turn(0)}}};
  const PosedScene posed = pose(scene, 1.0, 2.0);
  EXPECT_EQ(keys_of(posed.meshes[0]), 33u);
  EXPECT_EQ(keys_of(posed.meshes[1]), 65u);
  expect_matches_poses(scene, {1.0, 2.0}, 1.05e-3f);
  // A hundredth of the time: 0.9 degrees.
  EXPECT_EQ(keys_of(pose(scene, 1.0, 1.01).meshes[0]), 2u);
  expect_matches_poses(scene, {1.0, 1.01}, 1.05e-3f);
  // Bounded by the maximum: 129 keys for a full turn, twice as far away.
  scene.nodes[2].local.translation = {300, 0, 0};
  EXPECT_EQ(keys_of(pose(scene, 0.0, 4.0).meshes[1]), 129u);
}

TEST(Motion, AccountsForKeyframesInsideShutter) {
  Scene scene = two_squares();
  // An excursion within a hundredth of the shutter: no grid of eight would detect it.
  scene.animations = {{"",
                       {channel_of(2, AnimatedProperty::translation, {0, 0.401f, 0.405f, 0.409f, 1},
                                   {3, 0, 0, 3, 0, 0, 4, 0, 0, 3, 0, 0, 3, 0, 0})}}};
  const PosedScene posed = pose(scene, 0.0, 1.0);
  EXPECT_EQ(keys_of(posed.meshes[1]), 129u);
  // A corner in the path, on the grid of four segments.
  scene.animations = {{"", {channel_of(2, AnimatedProperty::translation, {0, 0.25f, 1}, {3, 0, 0, 4, 0, 0, 3, 9, 0})}}};
  EXPECT_EQ(keys_of(pose(scene, 0.0, 1.0).meshes[1]), 5u);
  expect_matches_poses(scene, {0.0, 1.0}, 1.05e-3f);
}

TEST(Motion, StepJumpTakesOneSegment) {
  Scene scene = two_squares();
  AnimationChannel jump = channel_of(2, AnimatedProperty::translation, {0, 0.505f}, {3, 0, 0, 3, 8, 0});
  jump.interpolation = Interpolation::step;
  scene.animations = {{"", {jump}}};
  const PosedScene posed = pose(scene, 0.0, 1.0);
  ASSERT_EQ(keys_of(posed.meshes[1]), 129u);
  const auto height = [&](double fraction) { return matrix_at(posed.meshes[1], fraction)[3][1]; };
  EXPECT_EQ(height(64.0 / 128), 0.0f);
  EXPECT_EQ(height(65.0 / 128), 8.0f);
}

TEST(Motion, GpuInstancesMoveWithTheirNode) {
  Scene scene = two_squares();
  Transform a, b;
  a.translation = {0, 5, 0};
  b.scale = {1, -2, 1};
  scene.nodes[1].gpu_instances = {a, b};
  scene.animations = {{"", {turn(0)}}};
  EXPECT_EQ(pose(scene, 0.0, 1.0).meshes.size(), 3u);
  expect_matches_poses(scene, {0.0, 1.0}, 2.1e-3f);
}

TEST(Motion, CamerasAndLightsStayRigid) {
  Scene scene = two_squares();
  scene.cameras = {SceneCamera()};
  scene.lights = {PunctualLight()};
  scene.nodes[2].camera = 0;
  scene.nodes[2].light = 0;
  scene.nodes[0].local.scale = {2, -3, 1};
  scene.animations = {{"", {turn(0)}}};
  const PosedScene posed = pose(scene, 0.0, 1.0);
  ASSERT_EQ(posed.cameras.size(), 1u);
  ASSERT_EQ(posed.lights.size(), 1u);
  const std::vector<M44f>& later = posed.cameras[0].later_transforms;
  ASSERT_GE(later.size(), 16u);
  EXPECT_EQ(posed.lights[0].later_transforms, later);
  for (size_t key = 0; key < later.size(); ++key) {
    const double time_s = static_cast<double>(key + 1) / static_cast<double>(later.size());
    EXPECT_EQ(later[key], pose(scene, {.time_s = time_s}).cameras[0].camera_to_world);
    EXPECT_NEAR(later[key].determinant(), 1.0f, 1e-5f);
  }
  EXPECT_EQ(posed.cameras[0].camera_to_world, pose(scene, {.time_s = 0.0}).cameras[0].camera_to_world);
}

TEST(Motion, VisibilityIsEvaluatedMidShutter) {
  Scene scene = two_squares();
  AnimationChannel hide = channel_of(1, AnimatedProperty::visible, {0, 1}, {1, 0});
  hide.interpolation = Interpolation::step;
  scene.animations = {{"", {hide}}};
  EXPECT_EQ(pose(scene, 0.0, 1.9).meshes.size(), 2u);
  EXPECT_EQ(pose(scene, 0.9, 2.0).meshes.size(), 1u);
}

// --- Deformation
// ----------------------------------------------------------------------------------

// The far square is bent by a target that moves one corner; its parent rotates and mirrors.
Scene morphing_squares() {
  Scene scene = two_squares();
  scene.meshes.push_back(scene.meshes[0]);
  Primitive& square = scene.meshes[1].primitives[0];
  square.normals.assign(4, V3f(0, 0, 1));
  square.tangents.assign(4, V4f(1, 0, 0, 1));
  MorphTarget lift;
  lift.positions = {V3f(0), V3f(0), V3f(0), V3f(0, 0, 2)};
  square.targets = {lift};
  scene.meshes[1].weights = {0};
  scene.nodes[2].mesh = 1;
  scene.nodes[0].local.scale = {1, -1, 1};
  scene.animations = {{"", {turn(0), channel_of(2, AnimatedProperty::weights, {0, 1}, {0, 1})}}};
  return scene;
}

TEST(Motion, MorphedMeshesAreInWorldSpaceAtEveryKey) {
  const Scene scene = morphing_squares();
  const Shutter shutter{0.0, 0.5};
  const PosedMesh mesh = pose(scene, {.shutter = shutter}).meshes.at(1);
  EXPECT_EQ(mesh.mesh_to_world, M44f());
  EXPECT_TRUE(mesh.later_transforms.empty());
  EXPECT_TRUE(mesh.clockwise);
  ASSERT_GE(mesh.later_deformed.size(), 16u);
  for (int i = 0; i <= 53; ++i) {
    const double fraction = i / 53.0;
    const PosedMesh still = pose(scene, {.time_s = 0.5 * fraction}).meshes.at(1);
    for (size_t v = 0; v < 4; ++v) {
      const V3f in_mesh =
          still.deformed.empty() ? scene.meshes[1].primitives[0].positions[v] : still.deformed[0].positions[v];
      EXPECT_LT((vertex_at(mesh, 0, v, fraction) - transform_point(still.mesh_to_world, in_mesh)).length(), 1.6e-3f);
    }
  }
  const PosedMesh::Deformed& last = mesh.later_deformed.back()[0];
  EXPECT_NEAR(last.normals[0].z, 1.0f, 1e-5f);
  EXPECT_NEAR(last.tangents[0].x, kHalfRoot, 1e-5f);
  EXPECT_EQ(last.tangents[0].w, -1.0f); // mirrored
  const Box3f box = world_bounds(scene, pose(scene, {.shutter = shutter}));
  EXPECT_NEAR(box.max.z, 1.0f, 1e-5f); // at the last key: half of the target
}

TEST(Motion, ConstantMorphIsNotDeformedPerKey) {
  Scene scene = morphing_squares();
  scene.meshes[1].weights = {0.5f};
  scene.animations = {{"", {turn(0)}}};
  const PosedMesh mesh = pose(scene, 0.0, 0.5).meshes.at(1);
  EXPECT_EQ(mesh.deformed.size(), 1u);
  EXPECT_TRUE(mesh.later_deformed.empty());
  EXPECT_GE(mesh.later_transforms.size(), 16u);
}

// Many vertices between two joints, the upper of which rotates.
Scene bending() {
  Scene scene;
  Primitive bar;
  constexpr int kVertices = 5000;
  for (int i = 0; i < kVertices; ++i) {
    const float y = 2.0f * static_cast<float>(i) / (kVertices - 1);
    bar.positions.emplace_back(0.1f * static_cast<float>(i % 3), y, 0.0f);
    bar.normals.emplace_back(0, 0, 1);
    bar.joints.push_back({0, 1, 0, 0});
    bar.weights.emplace_back(1.0f - 0.5f * y, 0.5f * y, 0.0f, 0.0f);
  }
  for (uint32_t i = 0; i + 2 < kVertices; ++i) bar.indices.insert(bar.indices.end(), {i, i + 1, i + 2});
  scene.meshes = {Mesh{.primitives = {bar}}};
  Node holder, foot, top;
  holder.mesh = 0;
  holder.skin = 0;
  foot.children = {2};
  top.local.translation = {0, 1, 0};
  scene.nodes = {holder, foot, top};
  scene.scenes = {SceneRoot{"", {0, 1}}};
  Skin skin;
  skin.joints = {1, 2};
  skin.inverse_bind_matrices = {M44f(), M44f(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1)};
  scene.skins = {skin};
  scene.animations = {{"", {turn(2)}}};
  return scene;
}

TEST(Motion, SkinnedVerticesMatchPoses) {
  const Scene scene = bending();
  const PosedMesh mesh = pose(scene, 0.2, 0.7).meshes.at(0);
  EXPECT_EQ(mesh.mesh_to_world, M44f());
  EXPECT_FALSE(mesh.clockwise);
  ASSERT_GE(mesh.later_deformed.size(), 8u);
  float worst = 0.0f;
  for (int i = 0; i <= 29; ++i) {
    const double fraction = i / 29.0;
    const PosedMesh still = pose(scene, {.time_s = 0.2 + 0.5 * fraction}).meshes.at(0);
    for (size_t v = 0; v < 5000; ++v)
      worst = std::max(worst, (vertex_at(mesh, 0, v, fraction) - still.deformed[0].positions[v]).length());
  }
  EXPECT_LT(worst, 1.05e-3f); // the radius is 1
  EXPECT_GT(worst, 1e-5f);    // and not because of too many keys
  EXPECT_EQ(keys_of(pose(scene, 5.0, 6.0).meshes.at(0)), 1u);
}

TEST(Motion, IsIndependentOfThreadCount) {
  Scene scene = bending();
  const PosedScene many = pose(scene, 0.2, 0.7);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const PosedScene single = pose(scene, 0.2, 0.7);
  ASSERT_EQ(many.meshes[0].later_deformed.size(), single.meshes[0].later_deformed.size());
  for (size_t key = 0; key < many.meshes[0].later_deformed.size(); ++key) {
    EXPECT_EQ(many.meshes[0].later_deformed[key][0].positions, single.meshes[0].later_deformed[key][0].positions);
    EXPECT_EQ(many.meshes[0].later_deformed[key][0].normals, single.meshes[0].later_deformed[key][0].normals);
  }
}

} // namespace
} // namespace kindling
