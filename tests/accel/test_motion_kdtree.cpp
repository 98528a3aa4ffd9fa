// Tests of the kd-tree in motion against the oracle, on every instruction set.
//
// KINDLING_MOTION_SEEDS=100000 sets the number of random scenes, KINDLING_MOTION_FIRST=17 the first
// seed; failures print their seed.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/motion_scenes.h"
#include "tests/accel/trials.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <tuple>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

class MovingKernels : public ::testing::TestWithParam<SimdTarget> {};

void compare_at(const TestScene& scene, const Accelerator& oracle, const Accelerator& tested, Rng& rng, float time,
                int count, Comparison& comparison) {
  const TestScene posed = scene.posed(time);
  std::vector<Ray> rays = aimed_rays(rng, posed, count);
  for (Ray& ray : rays) ray.time = time;
  cut_at_hits(rng, oracle, rays);
  compare(oracle, tested, rays, 1 + rng() % 100, comparison);
}

TEST_P(MovingKernels, AgreeWithBruteForce) {
  for (const TestScene& scene : {moving_instances(), deforming_meshes()}) {
    const auto oracle = build(Kind::brute_force, scene);
    BuildOptions options;
    options.simd = GetParam();
    const auto tested = build(Kind::kdtree, scene, options);
    Rng rng(631);
    Comparison comparison;
    const int count = GetParam() == best_simd_target() ? 500 : 120;
    for (const float time : some_times()) compare_at(scene, *oracle, *tested, rng, time, count, comparison);
    EXPECT_EQ(comparison.failures, 0U) << comparison.first_failure;
    EXPECT_GT(comparison.hits, comparison.rays / 10);
  }
}

TEST_P(MovingKernels, AgreeOnRandomMotion) {
  const auto first = static_cast<uint32_t>(number_from_environment("KINDLING_MOTION_FIRST", 1));
  const auto count =
      static_cast<uint32_t>(trials("KINDLING_MOTION_SEEDS", GetParam() == best_simd_target() ? 160 : 40));
  size_t rays = 0, hits = 0, failed_seeds = 0;
  for (uint32_t seed = first; seed < first + count && failed_seeds < 5; ++seed) {
    Rng rng(seed);
    const TestScene scene = random_motion(rng, seed % 16 == 0 ? 1000 : 100);
    BuildOptions options;
    options.simd = GetParam();
    options.quality = static_cast<Quality>(rng() % 3);
    const auto tested = build(Kind::kdtree, scene, options), oracle = build(Kind::brute_force, scene);
    Comparison comparison;
    for (int i = 0; i < 4; ++i) {
      const std::vector<float> times = some_times();
      const float time = i % 2 == 0 ? uniform(rng) : times[rng() % times.size()];
      compare_at(scene, *oracle, *tested, rng, time, 50, comparison);
    }
    rays += comparison.rays;
    hits += comparison.hits;
    if (comparison.failures != 0) {
      ++failed_seeds;
      ADD_FAILURE() << "seed " << seed << ": " << comparison.failures << " failures; " << comparison.first_failure;
    }
  }
  std::cout << rays << " rays, " << hits << " hit\n";
  EXPECT_GT(hits, rays / 5);
}

// No ray may leave a closed mesh, whatever its shape at the ray's time: rays from inside at its
// vertices and edges at that time.
TEST_P(MovingKernels, AreWatertight) {
  const V3f off(3.3f, -7.7f, 5.1f);
  for (const uint32_t keys : {2U, 5U})
    for (const bool at_origin : {true, false}) {
      const V3f center = at_origin ? V3f(0) : off;
      const TestScene scene(deformed(sphere(24, 48, 1.0f, center), keys, [&](const V3f& p, float time) {
        const V3f q = p - center;
        const float angle = 2.0f * time * (1.0f + q.z), c = std::cos(angle), s = std::sin(angle);
        return center + V3f(c * q.x - s * q.y, s * q.x + c * q.y, q.z) * (1.0f + 0.3f * time * std::sin(4.0f * q.y));
      }));
      BuildOptions options;
      options.simd = GetParam();
      const auto accelerator = build(Kind::kdtree, scene, options);
      Rng rng(641);
      std::vector<Ray> rays;
      for (int t = 0; t < 8; ++t) {
        const float time = t < 3 ? 0.5f * static_cast<float>(t) : uniform(rng);
        const TestScene posed = scene.posed(time);
        for (int i = 0; i < 400; ++i) {
          const auto triangle = static_cast<uint32_t>(rng() % (posed.mesh(0).indices.size() / 3));
          const V3f a = posed.mesh(0).corner(triangle, 0), b = posed.mesh(0).corner(triangle, 1);
          Ray ray;
          const V3f towards = uniform_direction(rng);
          ray.origin = center + towards * uniform(rng, 0.0f, 0.2f);
          ray.direction = (i % 2 == 0 ? a : a + (b - a) * uniform(rng)) - ray.origin;
          ray.t_max = kInfinity;
          ray.time = time;
          rays.push_back(ray);
        }
      }
      std::vector<Hit> hits(rays.size());
      std::vector<uint8_t> blocked(rays.size());
      accelerator->intersect(rays, hits);
      accelerator->occluded(rays, blocked);
      size_t leaks = 0;
      for (size_t i = 0; i < rays.size(); ++i) {
        leaks += hits[i].is_hit() ? 0 : 1;
        leaks += blocked[i] != 0 ? 0 : 1;
      }
      EXPECT_EQ(leaks, 0U) << keys << " keys";
    }
}

INSTANTIATE_TEST_SUITE_P(All, MovingKernels, ::testing::ValuesIn(simd_targets()), simd_label);

// Returns a sphere that twists, and triangles that scatter.
TestScene large_motion() {
  Rng rng(643);
  TestScene scene;
  scene.add_instance(scene.add_group({deformed(sphere(36, 72, 1.0f, V3f(0)), 3, Deformation::twist, 0.5f),
                                      sphere(20, 40, 0.5f, V3f(0)),
                                      deformed(triangle_soup(rng, 800, 1.5f, 0.1f), 2, Deformation::explode, 1.0f)}),
                     M44f());
  return scene;
}

TEST(MovingKdTree, IsIdenticalForAnyThreadCount) {
  const TestScene scene = large_motion();
  std::unique_ptr<Accelerator> one, four;
  tbb::task_arena(1).execute([&] { one = build(Kind::kdtree, scene); });
  tbb::task_arena(4).execute([&] { four = build(Kind::kdtree, scene); });
  const Statistics a = one->statistics(), b = four->statistics();
  EXPECT_EQ(std::make_tuple(a.memory_bytes, a.node_count, a.leaf_count, a.reference_count, a.leaf_sizes),
            std::make_tuple(b.memory_bytes, b.node_count, b.leaf_count, b.reference_count, b.leaf_sizes));
  Rng rng(647);
  for (Ray& ray : random_rays(rng, Box3f(V3f(-2), V3f(2)), 1000)) {
    ray.time = uniform(rng);
    const auto cost_a = *one->traversal_cost(ray, false), cost_b = *four->traversal_cost(ray, false);
    ASSERT_EQ(std::make_tuple(cost_a.nodes, cost_a.leaves, cost_a.triangles),
              std::make_tuple(cost_b.nodes, cost_b.leaves, cost_b.triangles));
  }
}

// A mesh that moves as a whole needs no more references than at rest, and hardly more visits.
TEST(MovingKdTree, BoxesMoveWithTheMesh) {
  const Mesh globe = sphere(60, 120, 1.0f, V3f(0));
  const TestScene resting(globe),
      moving(deformed(globe, 2, [](const V3f&p, float time) { return p + V3f(5, -3, 2) * time; }));
  const auto at_rest = build(Kind::kdtree, resting), in_motion = build(Kind::kdtree, moving);
  const Statistics a = at_rest->statistics(), b = in_motion->statistics();
  EXPECT_EQ(a.triangle_count, b.triangle_count);
  EXPECT_LT(static_cast<double>(b.reference_count), 1.3 * static_cast<double>(a.reference_count));
  Rng rng(653);
  uint64_t nodes_at_rest = 0, nodes_in_motion = 0, triangles_at_rest = 0, triangles_in_motion = 0;
  for (Ray ray : random_rays(rng, resting.bounds(), 2000)) {
    const TraversalCost before = *at_rest->traversal_cost(ray, false);
    nodes_at_rest += before.nodes;
    ray.time = uniform(rng);
    ray.origin += V3f(5, -3, 2) * ray.time;
    const TraversalCost now = *in_motion->traversal_cost(ray, false);
    nodes_in_motion += now.nodes;
    triangles_at_rest += before.triangles;
    triangles_in_motion += now.triangles;
  }
  EXPECT_LT(static_cast<double>(nodes_in_motion), 1.3 * static_cast<double>(nodes_at_rest));
  EXPECT_LT(static_cast<double>(triangles_in_motion), 1.3 * static_cast<double>(triangles_at_rest));
}

TEST(MovingKdTree, StatisticsCountMovingTriangles) {
  const TestScene scene = large_motion();
  const Statistics statistics = build(Kind::kdtree, scene)->statistics();
  size_t triangles = 0, references = 0;
  for (uint32_t m = 0; m < 3; ++m) triangles += scene.mesh(m).indices.size() / 3;
  EXPECT_EQ(statistics.triangle_count, triangles);
  for (size_t n = 0; n < statistics.leaf_sizes.size(); ++n) references += n * statistics.leaf_sizes[n];
  EXPECT_EQ(statistics.reference_count, references);
  EXPECT_GT(statistics.memory_bytes, 40 * triangles);
  EXPECT_LT(statistics.memory_bytes, 6000 * triangles);
}

TEST(MovingKdTree, ReportsProgressAndCancels) {
  const TestScene scene = large_motion();
  double last = 0.0;
  bool rising = true;
  std::atomic<bool> cancel{false};
  BuildOptions options;
  options.cancel = &cancel;
  options.on_progress = [&](double fraction) {
    rising = rising && fraction >= last && fraction <= 1.0;
    last = fraction;
  };
  ASSERT_NE(build(Kind::kdtree, scene, options), nullptr);
  EXPECT_TRUE(rising);
  EXPECT_EQ(last, 1.0);
  options.on_progress = [&](double fraction) { cancel.store(fraction > 0.2); };
  EXPECT_EQ(build(Kind::kdtree, scene, options), nullptr);
}

} // namespace
} // namespace kindling::accel::testing
