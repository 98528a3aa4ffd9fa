// Tests of motion: at each time, answers match those for the static scene at that time.
// SPDX-License-Identifier: Apache-2.0
#include "accel/motion.h"
#include "tests/accel/agreement.h"
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/motion_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

auto parts_of(const Hit& hit) {
  return hit.is_hit() ? std::make_tuple(hit.t, hit.u, hit.v, hit.instance, hit.mesh, hit.triangle)
                      : std::make_tuple(0.0f, 0.0f, 0.0f, kNoId, kNoId, kNoId);
}

// Returns rays through and at the scene at a time.
std::vector<Ray> rays_at(Rng& rng, const TestScene& posed, float time, int count) {
  std::vector<Ray> rays = random_rays(rng, posed.bounds(), count / 2);
  for (const std::vector<Ray>& more : {aimed_rays(rng, posed, count / 4), axis_parallel_rays(rng, posed, count / 4)})
    rays.insert(rays.end(), more.begin(), more.end());
  for (Ray& ray : rays) {
    ray.time = time;
    ray.key = rng();
  }
  return rays;
}

TestScene scene_of(int index) { return index == 0 ? moving_instances() : deforming_meshes(); }

TEST(Motion, KeyIntervalsAndInterpolation) {
  for (const uint32_t segments : {1U, 2U, 3U, 16U, 128U}) {
    for (uint32_t key = 0; key <= segments; ++key) {
      const KeyInterval at = key_interval(static_cast<float>(key) / static_cast<float>(segments), segments);
      EXPECT_NEAR(static_cast<float>(at.first) + at.fraction, static_cast<float>(key), 1e-4f);
      EXPECT_LT(at.first, segments);
      EXPECT_GE(at.fraction, 0.0f);
      EXPECT_LE(at.fraction, 1.0f);
    }
    EXPECT_EQ(key_interval(0.0f, segments).fraction, 0.0f);
    EXPECT_EQ(key_interval(1.0f, segments).fraction, 1.0f);
  }
  EXPECT_EQ(clamped_time(std::numeric_limits<float>::quiet_NaN()), 0.0f);
  EXPECT_EQ(clamped_time(7.0f), 1.0f);
  EXPECT_EQ(between(0.1f, 0.1f, 0.3f), 0.1f);
}

// The oracle of the moving scene must equal the oracle of the posed scene, bit for bit.
TEST(Motion, OracleMatchesPosedScene) {
  for (int index = 0; index < 2; ++index) {
    const TestScene scene = scene_of(index);
    const auto moving = build(Kind::brute_force, scene);
    Rng rng(613);
    size_t hits = 0, rays = 0;
    for (const float time : some_times()) {
      const TestScene posed = scene.posed(time);
      const auto static_oracle = build(Kind::brute_force, posed);
      for (const Ray& ray : rays_at(rng, posed, time, 400)) {
        const Hit expected = static_oracle->intersect(ray), found = moving->intersect(ray);
        ASSERT_EQ(parts_of(expected), parts_of(found)) << "time " << time;
        hits += expected.is_hit() ? 1 : 0;
        ++rays;
      }
    }
    EXPECT_GT(hits, rays / 10);
  }
}

class MovingInstances : public ::testing::TestWithParam<Kernels> {};
class DeformingMeshes : public ::testing::TestWithParam<Kernels> {};

void expect_agreement(const Kernels& kernels, const TestScene& scene) {
  const auto moving = build(kernels, scene);
  EXPECT_EQ(moving->statistics().instance_count, scene.instances().size());
  Rng rng(617);
  int failures = 0;
  for (const float time : some_times()) {
    const TestScene posed = scene.posed(time);
    const auto oracle = build(Kind::brute_force, posed);
    std::vector<Ray> rays = random_rays(rng, posed.bounds(), 600);
    for (Ray& ray : rays) ray.time = time;
    std::vector<Hit> hits(rays.size()), coherent(rays.size());
    std::vector<uint8_t> blocked(rays.size()), blocked_coherent(rays.size());
    moving->intersect(rays, hits);
    moving->intersect_coherent(rays, coherent);
    moving->occluded(rays, blocked);
    moving->occluded_coherent(rays, blocked_coherent);
    for (size_t i = 0; i < rays.size(); ++i) {
      const Hit expected = oracle->intersect(rays[i]), hit = moving->intersect(rays[i]);
      ASSERT_EQ(parts_of(hit), parts_of(hits[i]));
      ASSERT_EQ(moving->occluded(rays[i]), hit.is_hit());
      ASSERT_EQ(blocked[i], hit.is_hit() ? 1 : 0);
      for (const std::string& wrong :
           {disagreement(posed, rays[i], expected, hit), disagreement(posed, rays[i], expected, coherent[i]),
            disagreement_any(posed, *oracle, rays[i], expected, blocked_coherent[i] != 0)})
        if (!wrong.empty() && ++failures <= 3) ADD_FAILURE() << "time " << time << ": " << wrong;
    }
  }
  EXPECT_EQ(failures, 0);
}

TEST_P(MovingInstances, AgreeWithPosedScene) { expect_agreement(GetParam(), moving_instances()); }
TEST_P(DeformingMeshes, AgreeWithPosedScene) { expect_agreement(GetParam(), deforming_meshes()); }

// Bounds must enclose the scene at all times, and be tight for motion along straight lines.
void expect_bounds(const Kernels& kernels, const TestScene& scene) {
  const Box3f bounds = build(kernels, scene)->bounds();
  for (const float time : some_times()) {
    const Box3f posed = build(Kind::brute_force, scene.posed(time))->bounds();
    const V3f margin = (posed.max - posed.min) * 1e-5f;
    EXPECT_TRUE(bounds.intersects(posed.min + margin) && bounds.intersects(posed.max - margin)) << "time " << time;
  }
}

TEST_P(MovingInstances, BoundsEncloseMotion) { expect_bounds(GetParam(), moving_instances()); }
TEST_P(DeformingMeshes, BoundsEncloseMotion) {
  expect_bounds(GetParam(), deforming_meshes());
  TestScene scene;
  const uint32_t box = scene.add_group({gridded_box(2, V3f(0), V3f(1))});
  scene.add_instance(box, keys_of(2, M44f(), {0, 0, 1}, 0.0f, 1.0f, {10, 0, 0}));
  scene.add_instance(scene.add_group({deformed(gridded_box(2, V3f(0), V3f(1)), 2, Deformation::shift, -8.0f)}), M44f());
  const Box3f bounds = build(GetParam(), scene)->bounds();
  EXPECT_NEAR(bounds.min.x, -8.0f, 1e-3f);
  EXPECT_NEAR(bounds.max.x, 11.0f, 1e-3f);
}

TEST_P(DeformingMeshes, ReportsKnownHits) {
  TestScene scene;
  Mesh wall;
  wall.add_triangle({-1, -1, 0}, {1, -1, 0}, {0, 1, 0});
  const uint32_t static_group = scene.add_group({wall});
  const uint32_t bent = scene.add_group({wall, deformed(wall, 3, [](const V3f& p, float time) {
                                           return p + V3f(10, 0, time < 0.75f ? 4.0f * time : 0.0f);
                                         })});
  scene.add_instance(static_group, keys_of(2, M44f(), {0, 0, 1}, 0.0f, 1.0f, {0, 0, 8}));
  M44f aside;
  aside.setTranslation(V3f(0, 20, 0));
  scene.add_instance(bent, aside);
  const auto accelerator = build(GetParam(), scene);
  Ray ray;
  ray.t_max = kInfinity;
  ray.direction = {0, 0, -2};
  ray.origin = {0.0f, -0.5f, 20.0f};
  ray.time = 0.25f;
  Hit hit = accelerator->intersect(ray);
  EXPECT_EQ(std::make_tuple(hit.instance, hit.mesh, hit.triangle), std::make_tuple(0U, 0U, 0U));
  EXPECT_FLOAT_EQ(hit.t, 9.0f);
  EXPECT_NEAR(hit.v, 0.25f, 1e-5f);
  ray.origin = {10.0f, 19.5f, 20.0f}; // at x = 0 at key 0
  ray.time = 0.5f;
  hit = accelerator->intersect(ray);
  EXPECT_EQ(std::make_tuple(hit.instance, hit.mesh, hit.triangle), std::make_tuple(1U, 2U, 0U));
  EXPECT_FLOAT_EQ(hit.t, 9.0f);
  ray.time = 1.0f;
  EXPECT_FLOAT_EQ(accelerator->intersect(ray).t, 10.0f);
  ray.origin.x = 5.0f;
  ray.time = 0.25f; // halfway to key 1
  EXPECT_FLOAT_EQ(accelerator->intersect(ray).t, 9.5f);
  ray.time = 0.0f;
  EXPECT_FALSE(accelerator->intersect(ray).is_hit());
  EXPECT_FALSE(accelerator->occluded(ray));
}

bool accept_by_parity(const void*, const Ray& ray, const Hit& hit) { return ((hit.triangle ^ ray.key) & 1U) != 0; }

TEST_P(DeformingMeshes, RefusedHitsRevealHitsBehind) {
  Rng rng(619);
  TestScene scene;
  Mesh leaves = triangle_soup(rng, 200, 1.0f, 0.4f);
  leaves.opaque = false;
  Mesh waving = deformed(leaves, 3, Deformation::twist, 1.0f);
  const uint32_t static_group = scene.add_group({leaves}),
                 group = scene.add_group({waving, sphere(6, 12, 0.4f, V3f(0))});
  scene.add_instance(static_group, keys_of(3, M44f(), {1, 1, 0}, 1.0f, 1.0f, {2, 0, 0}));
  scene.add_instance(group, M44f());
  scene.set_filter({accept_by_parity, nullptr});
  const auto accelerator = build(GetParam(), scene);
  int failures = 0, refused = 0;
  for (const float time : {0.0f, 0.3f, 0.5f, 1.0f}) {
    const TestScene posed = scene.posed(time);
    const auto oracle = build(Kind::brute_force, posed);
    for (Ray ray : random_rays(rng, Box3f(V3f(-1), V3f(3, 1, 1)), 1000)) {
      ray.time = time;
      ray.key = rng();
      const Hit expected = oracle->intersect(ray), hit = accelerator->intersect(ray);
      const std::string wrong = disagreement(posed, ray, expected, hit);
      if (!wrong.empty() && ++failures <= 3) ADD_FAILURE() << wrong;
      ASSERT_EQ(accelerator->occluded(ray), hit.is_hit());
      Ray other = ray;
      other.key ^= 1U;
      refused += parts_of(oracle->intersect(other)) != parts_of(expected) ? 1 : 0;
    }
  }
  EXPECT_EQ(failures, 0);
  EXPECT_GT(refused, 400);
}

INSTANTIATE_TEST_SUITE_P(All, MovingInstances, ::testing::ValuesIn(all_kernels()), kernels_label);
INSTANTIATE_TEST_SUITE_P(All, DeformingMeshes, ::testing::ValuesIn(all_kernels()), kernels_label);

} // namespace
} // namespace kindling::accel::testing
