// Tests of coherent queries through instances, at rest and moving, on every instruction set.
// Groups of rays that stay together have the oracle's hits, bit for bit.
//
// KINDLING_PACKET_SEEDS=10000 sets the number of random scenes; failures print their seed.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/motion_scenes.h"
#include "tests/accel/trials.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kindling::accel::testing {
namespace {

class InstancePackets : public ::testing::TestWithParam<SimdTarget> {
 protected:
  // Traces groups of rays, each at a time of its own unless the scene is at rest.
  static void compare_with_oracle(const TestScene& scene, Rng& rng, int groups, bool moves, Comparison& comparison) {
    BuildOptions options;
    options.simd = GetParam();
    const auto tested = build(Kind::kdtree, scene, options), oracle = build(Kind::brute_force, scene);
    std::vector<Ray> rays = coherent_rays(rng, moves ? scene.posed(uniform(rng)) : scene, groups);
    if (moves)
      for (Ray& ray : rays) ray.time = rng() % 8 == 0 ? some_times()[rng() % some_times().size()] : uniform(rng);
    cut_at_hits(rng, *oracle, rays);
    const size_t batches[] = {64, 256, 40, rays.size()};
    compare(*oracle, *tested, rays, batches[rng() % 4], comparison);
  }
};

// Many small instances, overlapping, between a camera and a floor.
TEST_P(InstancePackets, AgreeAmongManyInstances) {
  for (const bool cut_outs : {false, true}) {
    Rng rng(911);
    TestScene scene;
    scene.add_instance(scene.add_group({terrain(12, 8.0f, 1.0f)}), M44f());
    Mesh pebble = sphere(8, 12, 0.3f, V3f(0));
    pebble.opaque = !cut_outs;
    const uint32_t group = scene.add_group({pebble, gridded_box(3, V3f(-0.2f), V3f(0.2f))});
    for (int i = 0; i < 200; ++i) {
      const V3f axis = uniform_direction(rng), at = uniform_in(rng, Box3f(V3f(-4), V3f(4)));
      const float size = uniform(rng, 0.3f, 1.0f);
      scene.add_instance(group, placed(V3f(size), axis, uniform(rng, 0.0f, 6.0f), at));
    }
    if (cut_outs)
      scene.set_filter(
          {[](const void*, const Ray& ray, const Hit& hit) { return (ray.key + hit.triangle) % 3 != 0; }, nullptr});
    Comparison comparison;
    compare_with_oracle(scene, rng, 60, false, comparison);
    EXPECT_EQ(comparison.failures, 0U) << comparison.first_failure;
    EXPECT_GT(comparison.hits, comparison.rays / 4);
  }
}

TEST_P(InstancePackets, AgreeInMotion) {
  for (const TestScene& scene : {moving_instances(), deforming_meshes()}) {
    Rng rng(913);
    Comparison comparison;
    compare_with_oracle(scene, rng, 40, true, comparison);
    EXPECT_EQ(comparison.failures, 0U) << comparison.first_failure;
    EXPECT_GT(comparison.hits, comparison.rays / 10);
  }
}

TEST_P(InstancePackets, AgreeOnRandomScenes) {
  const auto count =
      static_cast<uint32_t>(trials("KINDLING_PACKET_SEEDS", GetParam() == best_simd_target() ? 200 : 60));
  size_t rays = 0, hits = 0;
  for (uint32_t seed = 1; seed <= count; ++seed) {
    Rng rng(seed);
    const bool moves = rng() % 2 == 0;
    const TestScene scene = moves ? random_motion(rng, 100) : random_scene(rng, 100);
    Comparison comparison;
    compare_with_oracle(scene, rng, 4, moves, comparison);
    rays += comparison.rays;
    hits += comparison.hits;
    ASSERT_EQ(comparison.failures, 0U) << "seed " << seed << ": " << comparison.first_failure;
  }
  EXPECT_GT(hits, rays / 10);
}

INSTANTIATE_TEST_SUITE_P(All, InstancePackets, ::testing::ValuesIn(simd_targets()), simd_label);

} // namespace
} // namespace kindling::accel::testing
