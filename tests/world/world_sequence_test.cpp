// Tests that Worlds of a sequence equal separately built ones, and share unchanged parts.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/world_sequence.h"

#include "renderer/world/build_world.h"
#include "renderer/world/persistent_meshes.h"

#include <gtest/gtest.h>

#include <cstring>

namespace kindling {
namespace {

Primitive triangle(float size) {
  Primitive primitive;
  primitive.positions = {V3f(0.0f), V3f(size, 0.0f, 0.0f), V3f(0.0f, size, 0.0f)};
  primitive.normals.assign(3, V3f(0.0f, 0.0f, 1.0f));
  primitive.indices = {0, 1, 2};
  return primitive;
}

int add_node(Scene& scene, int mesh, const V3f& at) {
  Node& node = scene.nodes.emplace_back();
  node.mesh = mesh;
  node.local.translation = at;
  return static_cast<int>(scene.nodes.size() - 1);
}

void move(Scene& scene, int node) {
  AnimationChannel channel;
  channel.node = node;
  channel.times_s = {0.0f, 1.0f};
  channel.values = {0.0f, 0.0f, 0.0f, 0.0f, 3.0f, 0.0f};
  scene.animations.emplace_back().channels.push_back(channel);
}

// Node 0 is static, 1 moves, 2 and 3 share a mesh, of which 3 moves; 4 is morphed; 5 has a moving
// camera.
Scene make_scene() {
  Scene scene;
  for (int mesh = 0; mesh < 4; ++mesh)
    scene.meshes.emplace_back().primitives.push_back(triangle(1.0f + static_cast<float>(mesh)));
  scene.materials.resize(2);
  scene.materials[1].base_color_factor = V4f(0.1f, 0.2f, 0.3f, 1.0f);
  for (Mesh& mesh : scene.meshes) mesh.primitives[0].material = 1;
  add_node(scene, 0, V3f(0.0f));
  move(scene, add_node(scene, 1, V3f(5.0f, 0.0f, 0.0f)));
  add_node(scene, 2, V3f(0.0f, 0.0f, 1.0f));
  move(scene, add_node(scene, 2, V3f(0.0f, 0.0f, 2.0f)));
  add_node(scene, 3, V3f(-5.0f, 0.0f, 0.0f));
  scene.meshes[3].primitives[0].targets.emplace_back().positions.assign(3, V3f(0.0f, 0.0f, 1.0f));
  scene.meshes[3].weights = {0.0f};
  move(scene, add_node(scene, kNone, V3f(0.0f)));
  scene.nodes.back().camera = 0;
  scene.cameras.resize(1);
  return scene;
}

PosedScene pose(const Scene& scene, double time_s) { return pose_scene(scene, {kNone, time_s, std::nullopt}).value(); }

// Compares the traced data bit for bit.
void expect_same(const World& a, const World& b) {
  const accel::BuildInput x = a.accelerator_input(), y = b.accelerator_input();
  ASSERT_EQ(x.meshes.size(), y.meshes.size());
  for (size_t m = 0; m < x.meshes.size(); ++m) {
    ASSERT_EQ(x.meshes[m].positions.size(), y.meshes[m].positions.size()) << m;
    EXPECT_EQ(
        std::memcmp(x.meshes[m].positions.data(), y.meshes[m].positions.data(), x.meshes[m].positions.size_bytes()), 0)
        << m;
    EXPECT_TRUE(std::equal(x.meshes[m].indices.begin(), x.meshes[m].indices.end(), y.meshes[m].indices.begin(),
                           y.meshes[m].indices.end()));
  }
  for (uint32_t i = 0; i < x.instances.size(); ++i)
    for (uint32_t m = x.groups[x.instances[i].group].first_mesh;
         m < x.groups[x.instances[i].group].first_mesh + x.groups[x.instances[i].group].mesh_count; ++m) {
      accel::Ray ray;
      ray.direction = V3f(0.0f, 0.0f, -1.0f);
      accel::Hit hit;
      hit.instance = i;
      hit.mesh = m;
      hit.triangle = 0;
      hit.t = 1.0f;
      SurfacePoint of_a, of_b;
      a.surface_at(ray, hit, of_a);
      b.surface_at(ray, hit, of_b);
      EXPECT_EQ(of_a.material, of_b.material) << m;
      EXPECT_EQ(of_a.bsdf.base_color, of_b.bsdf.base_color) << m;
    }
  EXPECT_EQ(a.bounds, b.bounds);
  EXPECT_EQ(a.statistics().geometry_bytes, b.statistics().geometry_bytes);
}

TEST(WorldSequence, EqualsSeparatelyBuiltWorlds) {
  Scene scene = make_scene();
  WorldSequence worlds;
  const WorldOptions options;
  for (const double time_s : {0.25, 1.0, 0.5, 0.5, 0.0}) {
    SCOPED_TRACE(time_s);
    const Result<const World*> world = worlds.next(scene, pose(scene, time_s), options, time_s > 0.0, nullptr, nullptr);
    ASSERT_TRUE(world.ok());
    Scene alone = make_scene();
    PosedScene posed = pose(alone, time_s);
    const auto single = build_world(std::move(alone), std::move(posed), options, nullptr, nullptr);
    ASSERT_TRUE(single.ok());
    expect_same(*world.value(), *single.value());
  }
}

// Every copy of a mesh with several placements has the mesh's material.
TEST(WorldSequence, CopiesKeepTheirMaterial) {
  for (const bool more : {true, false}) {
    Scene scene = make_scene();
    WorldSequence worlds;
    const World* world = worlds.next(scene, pose(scene, 0.0), {}, more, nullptr, nullptr).value();
    const size_t meshes = world->accelerator_input().meshes.size();
    ASSERT_EQ(meshes, 5U);
    for (uint32_t mesh = 0; mesh < meshes; ++mesh) {
      accel::Ray ray;
      ray.direction = V3f(0.0f, 0.0f, -1.0f);
      accel::Hit hit;
      hit.instance = 0;
      hit.mesh = mesh;
      hit.triangle = 0;
      SurfacePoint surface;
      world->surface_at(ray, hit, surface);
      EXPECT_EQ(surface.material, 1U) << mesh;
    }
  }
}

TEST(WorldSequence, CameraMotionKeepsWorld) {
  Scene scene = make_scene();
  for (const size_t animation : {0, 1}) scene.animations[animation].channels.clear();
  WorldSequence worlds;
  const World* first = worlds.next(scene, pose(scene, 0.0), {}, true, nullptr, nullptr).value();
  EXPECT_EQ(worlds.next(scene, pose(scene, 0.5), {}, true, nullptr, nullptr).value(), first);
  scene.meshes[3].weights = {0.5f}; // deforms
  const World* deformed = worlds.next(scene, pose(scene, 0.5), {}, true, nullptr, nullptr).value();
  EXPECT_EQ(deformed->bounds.max.z, 2.0f);
}

TEST(WorldSequence, StaticGeometryIsReused) {
  Scene scene = make_scene();
  WorldSequence worlds;
  const auto positions = [](const World& world, size_t mesh) {
    return world.accelerator_input().meshes[mesh].positions.data();
  };
  const World* world = worlds.next(scene, pose(scene, 0.0), {}, true, nullptr, nullptr).value();
  const V3f* standing = positions(*world, 0);
  EXPECT_TRUE(scene.meshes[0].primitives[0].positions.empty()) << "it has two placements";
  EXPECT_FALSE(scene.meshes[1].primitives[0].positions.empty());
  world = worlds.next(scene, pose(scene, 1.0), {}, true, nullptr, nullptr).value();
  EXPECT_EQ(positions(*world, 0), standing);
  EXPECT_EQ(positions(*world, 1)[0].y, 3.0f);
}

// Returns the persistent flags of meshes, by node.
std::vector<uint8_t> persistent_nodes(const Scene& scene, double time_s, const WorldOptions& options) {
  Scene consumed = scene;
  const PosedScene posed = pose(scene, time_s);
  const auto world = build_world(std::move(consumed), posed, options, nullptr, nullptr).value();
  const accel::BuildInput input = world->accelerator_input();
  std::vector<uint8_t> persistent;
  for (const accel::TriangleMesh& mesh : input.meshes) persistent.push_back(mesh.persistent_id != 0 ? 1 : 0);
  return persistent;
}

TEST(WorldSequence, MarksPersistentMeshes) {
  Scene scene = make_scene();
  Primitive& large = scene.meshes[0].primitives[0];
  for (int i = 0; i < 30; ++i)
    for (const uint32_t corner : {0U, 1U, 2U}) large.indices.push_back(corner);
  WorldOptions options;
  options.min_persistent_triangles = 0;
  using Nodes = std::vector<uint8_t>;
  EXPECT_EQ(persistent_nodes(scene, 0.5, options),
            (Nodes{1, 0, 1, 0, 1})); // the last one could be deformed, but is not
  options.min_persistent_triangles = 34;
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{0, 0, 0, 0, 0}));
  options.min_persistent_triangles = 33;
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{1, 0, 1, 0, 1}));
  // The same 33 for an image of many samples.
  options.min_persistent_triangles = 0;
  options.image_samples = 34 * kMaxSamplesPerPersistentTriangle;
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{0, 0, 0, 0, 0}));
  --options.image_samples;
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{1, 0, 1, 0, 1}));
  options.image_samples = 0;
  // Two triangles are not persistent, so eight must be.
  large.indices.resize(3 * 5);
  options.min_persistent_triangles = 0;
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{0, 0, 0, 0, 0}));
  large.indices.resize(3 * 6, 1);
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{1, 0, 1, 0, 1}));
  // Hidden at some time, even if not at this one.
  AnimationChannel channel;
  channel.node = 2;
  channel.property = AnimatedProperty::visible;
  channel.components = 1;
  channel.interpolation = Interpolation::step;
  channel.times_s = {0.0f, 0.9f};
  channel.values = {1.0f, 0.0f};
  scene.animations[0].channels.push_back(channel);
  large.indices.resize(3 * 31, 1);
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{1, 0, 0, 0, 1}));
  EXPECT_EQ(persistent_nodes(scene, 1.0, options), (Nodes{1, 0, 0, 1}));
  // With a material that changes.
  channel.property = AnimatedProperty::member;
  channel.node = kNone;
  channel.member = {AnimatedMember::Owner::material, false, 0, 1};
  scene.animations[0].channels.push_back(channel);
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{0, 0, 0, 0, 0}));
  // At rest, and without animations.
  scene = make_scene();
  EXPECT_FALSE(pose_scene(scene, {}).value().animated);
  scene.animations.clear();
  EXPECT_EQ(persistent_nodes(scene, 0.5, options), (Nodes{0, 0, 0, 0, 0}));
}

TEST(WorldSequence, FindsStaticMeshes) {
  Scene scene = make_scene();
  EXPECT_EQ(find_static_meshes(scene), (std::vector<uint8_t>{1, 0, 0, 0}));
  scene.nodes[1].children = {0}; // a moving parent
  EXPECT_EQ(find_static_meshes(scene)[0], 0);
  scene.nodes[1].children = {};
  EXPECT_EQ(find_static_meshes(scene)[0], 1);
  AnimationChannel channel;
  channel.property = AnimatedProperty::member;
  channel.member = {AnimatedMember::Owner::material, false, 0, 1};
  scene.animations[0].channels.push_back(channel);
  EXPECT_EQ(find_static_meshes(scene)[0], 0);
}

} // namespace
} // namespace kindling
