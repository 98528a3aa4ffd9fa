// Tests of hit filters: which meshes call them, candidate data, and hits behind refused ones.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/accel_scenes.h"
#include "tests/accel/agreement.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

M44f moved_by(const V3f& translation) {
  M44f m;
  m.setTranslation(translation);
  return m;
}

class Filters : public ::testing::TestWithParam<Kernels> {};

// Accepts by a hash of the arguments, so that any wrong argument changes the answer.
bool accept_by_hash(const void*, const Ray& ray, const Hit& candidate) {
  uint32_t h = ray.key * 2654435761U ^ candidate.triangle * 40503U ^ candidate.mesh * 97U ^ candidate.instance * 31U;
  h ^= h >> 15;
  return (h & 3) != 0;
}

TestScene layered_scene() {
  Rng rng(53);
  TestScene scene;
  Mesh leaves = triangle_soup(rng, 400, 1.0f, 0.4f);
  leaves.opaque = false;
  Mesh solid = triangle_soup(rng, 100, 1.0f, 0.2f);
  Mesh glass = sphere(8, 16, 0.8f, V3f(0));
  glass.opaque = false;
  const uint32_t tree = scene.add_group({leaves, solid});
  const uint32_t sphere = scene.add_group({glass});
  scene.add_instance(tree, M44f());
  scene.add_instance(sphere, M44f());
  scene.add_instance(tree, moved_by({2, 0, 0}));
  M44f mirrored = moved_by({0, 2, 0});
  mirrored[2][2] = -1.5f;
  scene.add_instance(sphere, mirrored);
  return scene;
}

TEST_P(Filters, AgreeWithBruteForce) {
  TestScene scene = layered_scene();
  scene.set_filter({accept_by_hash, nullptr});
  const auto oracle = build(Kind::brute_force, scene);
  const auto accelerator = build(GetParam(), scene);
  Rng rng(59);
  std::vector<Ray> rays = random_rays(rng, Box3f(V3f(-1), V3f(3)), 4000);
  std::vector<Hit> hits(rays.size()), coherent(rays.size());
  std::vector<uint8_t> blocked(rays.size());
  accelerator->intersect(rays, hits);
  accelerator->intersect_coherent(rays, coherent);
  accelerator->occluded(rays, blocked);
  int filtered = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const Hit expected = oracle->intersect(rays[i]), hit = accelerator->intersect(rays[i]);
    ASSERT_EQ(disagreement(scene, rays[i], expected, hit), "");
    ASSERT_EQ(std::memcmp(&hit, &hits[i], sizeof(Hit)), 0);
    ASSERT_EQ(disagreement(scene, rays[i], hit, coherent[i]), "");
    ASSERT_EQ(blocked[i] != 0, hit.is_hit());
    ASSERT_EQ(accelerator->occluded(rays[i]), hit.is_hit());
    filtered += expected.is_hit() && !scene.mesh(expected.mesh).opaque ? 1 : 0;
  }
  EXPECT_GT(filtered, 500);
}

struct Record {
  const TestScene* scene = nullptr;
  const Ray* ray = nullptr;
  mutable std::atomic<int> calls{0};
  mutable std::atomic<int> wrong{0};
};

// Refuses every candidate, after checking it against the geometry.
bool refuse_and_check(const void* context, const Ray& ray, const Hit& candidate) {
  const auto& record = *static_cast<const Record*>(context);
  ++record.calls;
  const Instance& instance = record.scene->instances()[candidate.instance];
  const Mesh& mesh = record.scene->mesh(candidate.mesh);
  const V3f at_triangle =
      (mesh.corner(candidate.triangle, 0) * (1.0f - candidate.u - candidate.v) +
       mesh.corner(candidate.triangle, 1) * candidate.u + mesh.corner(candidate.triangle, 2) * candidate.v) *
      instance.object_to_world;
  const V3f at_ray = ray.origin + ray.direction * candidate.t;
  const bool in_range = candidate.t > ray.t_min && candidate.t <= ray.t_max;
  const bool same_ray = ray.key == record.ray->key && ray.time == record.ray->time &&
                        ray.origin == record.ray->origin && ray.direction == record.ray->direction &&
                        ray.t_max == record.ray->t_max;
  // The soup has triangles seen almost edge-on: the tolerance is far above rounding and far below
  // the effect of a wrong id.
  if (mesh.opaque || !in_range || !same_ray || (at_triangle - at_ray).length() > 1e-3f) ++record.wrong;
  return false;
}

TEST_P(Filters, CandidatesAreComplete) {
  TestScene scene = layered_scene();
  Record record;
  record.scene = &scene;
  scene.set_filter({refuse_and_check, &record});
  const auto accelerator = build(GetParam(), scene);
  Rng rng(61);
  for (Ray ray : random_rays(rng, Box3f(V3f(-1), V3f(3)), 1000)) {
    ray.time = 0.25f;
    record.ray = &ray;
    const Hit hit = accelerator->intersect(ray);
    if (hit.is_hit()) {
      EXPECT_TRUE(scene.mesh(hit.mesh).opaque);
    }
    EXPECT_EQ(accelerator->occluded(ray), hit.is_hit());
  }
  EXPECT_GT(record.calls.load(), 2000);
  EXPECT_EQ(record.wrong.load(), 0);
}

TEST_P(Filters, AcceptsAllHitsWithoutFilter) {
  const TestScene scene = layered_scene();
  const auto accelerator = build(GetParam(), scene);
  Ray ray;
  ray.origin = V3f(0, 0, 0);
  ray.direction = {0, 0, 1};
  ray.t_max = kInfinity;
  EXPECT_TRUE(accelerator->intersect(ray).is_hit());
}

TEST_P(Filters, RefusedCoplanarHitsRevealFloor) {
  Rng rng(67);
  Mesh pile = coplanar_pile(rng, 300), floor;
  pile.opaque = false;
  floor.add_triangle({-9, -1, -9}, {9, -1, -9}, {0, -1, 9});
  TestScene scene;
  scene.add_instance(scene.add_group({pile, floor}), M44f());
  Record record;
  record.scene = &scene;
  scene.set_filter({refuse_and_check, &record});
  const auto accelerator = build(GetParam(), scene);
  Ray ray;
  ray.origin = {0.0f, 2.0f, 0.0f};
  ray.direction = {0, -1, 0};
  ray.t_max = kInfinity;
  ray.key = 5;
  record.ray = &ray;
  const Hit hit = accelerator->intersect(ray);
  EXPECT_EQ(hit.mesh, 1U);
  EXPECT_FLOAT_EQ(hit.t, 3.0f);
  EXPECT_GT(record.calls.load(), 5);
  EXPECT_EQ(record.wrong.load(), 0);
}

INSTANTIATE_TEST_SUITE_P(All, Filters, ::testing::ValuesIn(all_kernels()), kernels_label);

} // namespace
} // namespace kindling::accel::testing
