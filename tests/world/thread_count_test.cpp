// Tests that a World does not depend on the number of threads that build it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/prepare_geometry.h"
#include "renderer/world/world_parts.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <random>

namespace kindling {
namespace {

Primitive soup(uint32_t triangles, uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-23f - 1.0f; };
  Primitive primitive;
  primitive.texcoords.resize(2);
  for (uint32_t v = 0; v < 3 * triangles; ++v) {
    primitive.positions.push_back({uniform(), uniform(), v % 5 == 0 ? -0.0f : v % 5 == 1 ? 0.0f : -uniform()});
    primitive.normals.push_back(V3f{uniform(), uniform(), 1.5f}.normalized());
    primitive.texcoords[0].push_back({uniform(), uniform()});
    if (seed % 2 == 0) primitive.tangents.emplace_back(1.0f, 0.0f, 0.0f, 1.0f);
    if (seed % 3 == 0) primitive.colors.push_back({uniform(), uniform(), uniform(), 1.0f});
    primitive.indices.push_back((v * 7919) % (3 * triangles));
  }
  primitive.material = static_cast<int>(seed % 2);
  return primitive;
}

// Meshes with one or several placements, mirrored, flattened, instanced, deformed and moving, small
// and large.
Scene many_meshes() {
  Scene scene;
  scene.materials.resize(3);
  scene.materials[0].normal_texture.texture = 0;
  scene.textures.resize(1);
  for (uint32_t mesh = 0; mesh < 12; ++mesh) {
    Mesh& added = scene.meshes.emplace_back();
    for (uint32_t p = 0; p < 3; ++p)
      added.primitives.push_back(soup(mesh == 3 ? 40000 : mesh == 4 ? 30000 : 50 + mesh, 3 * mesh + p));
    if (mesh == 5) added.primitives[1].indices.clear();
  }
  std::mt19937 random(1);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  for (uint32_t n = 0; n < 60; ++n) {
    Node& node = scene.nodes.emplace_back();
    node.mesh = static_cast<int>(n < 12 ? n : n % 5 == 0 ? 4 : n % 11);
    node.local.translation = V3f{uniform(), uniform(), 5.0f * uniform()};
    node.local.scale = n % 7 == 3 ? V3f(-1.0f, 2.0f, 1.0f) : n % 13 == 5 ? V3f(1.0f, 0.0f, 1.0f) : V3f(1.0f);
    if (n % 9 == 4) {
      AnimationChannel channel;
      channel.node = static_cast<int>(n);
      channel.times_s = {0.0f, 1.0f};
      channel.values = {0.0f, 0.0f, 0.0f, 0.0f, 3.0f, 0.0f};
      scene.animations.emplace_back().channels.push_back(channel);
    }
  }
  for (Primitive& primitive : scene.meshes[6].primitives) {
    primitive.targets.emplace_back().positions.assign(primitive.positions.size(), V3f(0.0f, 0.0f, 1.0f));
    primitive.targets.back().normals.assign(primitive.positions.size(), V3f(0.1f, 0.0f, 0.0f));
  }
  scene.meshes[6].weights = {0.5f};
  return scene;
}

struct Prepared {
  PreparedGeometry geometry;
  std::vector<GeometryKey> keys;
};

Prepared prepare(size_t threads, bool shutter, bool keep_scene) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Scene scene = many_meshes();
  PoseOptions pose{kNone, 0.25, std::nullopt};
  if (shutter) pose.shutter = Shutter{0.0, 0.5};
  PosedScene posed = pose_scene(scene, pose).value();
  WorldParts parts;
  parts.keep_scene = keep_scene;
  parts.static_meshes.assign(scene.meshes.size(), 0);
  parts.static_meshes[3] = 1;
  Prepared prepared{prepare_geometry(scene, posed, &parts), {}};
  prepared.keys = std::move(parts.keys);
  return prepared;
}

template <typename A>
void expect_same_bits(const A& a, const A& b) {
  ASSERT_EQ(a.size(), b.size());
  if (!a.empty()) {
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]), 0);
  }
}

void expect_same_geometry(const Prepared& one, const Prepared& four) {
  const PreparedGeometry &a = one.geometry, &b = four.geometry;
  EXPECT_EQ(one.keys, four.keys);
  EXPECT_EQ(std::memcmp(&a.bounds, &b.bounds, sizeof a.bounds), 0); // including signs of zeros
  ASSERT_EQ(a.geometries.size(), b.geometries.size());
  for (size_t g = 0; g < a.geometries.size(); ++g) {
    SCOPED_TRACE(g);
    const Geometry &x = a.geometries[g], &y = b.geometries[g];
    EXPECT_EQ(x.material, y.material);
    EXPECT_EQ(x.to_object, y.to_object);
    EXPECT_EQ(x.stride, y.stride);
    expect_same_bits(x.positions, y.positions);
    expect_same_bits(x.indices, y.indices);
    expect_same_bits(x.attributes, y.attributes);
    ASSERT_EQ(x.later_positions.size(), y.later_positions.size());
    for (size_t key = 0; key < x.later_positions.size(); ++key) {
      expect_same_bits(x.later_positions[key], y.later_positions[key]);
      expect_same_bits(x.later_frames[key], y.later_frames[key]);
    }
  }
  ASSERT_EQ(a.groups.size(), b.groups.size());
  for (size_t g = 0; g < a.groups.size(); ++g) {
    EXPECT_EQ(a.groups[g].first_mesh, b.groups[g].first_mesh);
    EXPECT_EQ(a.groups[g].mesh_count, b.groups[g].mesh_count);
  }
  EXPECT_EQ(a.motions, b.motions);
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (size_t i = 0; i < a.instances.size(); ++i) {
    EXPECT_EQ(a.instances[i].group, b.instances[i].group);
    EXPECT_EQ(a.instances[i].object_to_world, b.instances[i].object_to_world);
    EXPECT_EQ(a.instances[i].first_mesh, b.instances[i].first_mesh);
    EXPECT_EQ(a.instances[i].mirrored, b.instances[i].mirrored);
    EXPECT_EQ(a.instances[i].moving, b.instances[i].moving);
  }
}

TEST(ThreadCount, DoesNotAffectGeometry) {
  for (const bool shutter : {false, true})
    for (const bool keep_scene : {false, true}) {
      SCOPED_TRACE(testing::Message() << "shutter " << shutter << ", keep_scene " << keep_scene);
      const Prepared one = prepare(1, shutter, keep_scene);
      EXPECT_GT(one.geometry.instances.size(), 10U);
      EXPECT_GT(one.geometry.geometries.size(), 30U);
      for (int round = 0; round < 3; ++round) expect_same_geometry(one, prepare(4, shutter, keep_scene));
    }
}

// Copying or consuming a mesh, and the other meshes prepared in parallel, must not affect the
// result.
TEST(ThreadCount, CopiedAndConsumedMeshesAreEqual) {
  const Prepared consumed = prepare(4, false, false), copied = prepare(4, false, true);
  expect_same_geometry(consumed, copied);
}

// Each geometry belongs to its own primitive and placement.
TEST(ThreadCount, EveryGeometryHasItsOwnPrimitive) {
  const Scene scene = many_meshes();
  const Prepared prepared = prepare(4, false, false);
  for (size_t g = 0; g < prepared.keys.size(); ++g) {
    const GeometryKey& key = prepared.keys[g];
    if (key.mesh == kNone) continue; // deformed
    Primitive primitive = scene.meshes[static_cast<size_t>(key.mesh)].primitives[key.primitive];
    const Geometry alone =
        make_geometry({std::move(primitive), key.bake, key.material, false, {}}, scene.materials[key.material]);
    expect_same_bits(prepared.geometry.geometries[g].positions, alone.positions);
    expect_same_bits(prepared.geometry.geometries[g].indices, alone.indices);
    expect_same_bits(prepared.geometry.geometries[g].attributes, alone.attributes);
  }
}

} // namespace
} // namespace kindling
