// Tests of the query of every crossing of many rays: its answers are those of the single query.
//
// KINDLING_ALL_HITS_SEEDS=100000 sets the number of random scenes, KINDLING_ALL_HITS_RAYS the rays
// through each scene.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/all_hits_trials.h"
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/motion_scenes.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <utility>

namespace kindling::accel::testing {
namespace {

// Tests that run by each instruction set of the kd-tree's kernels.
class AllHitsBatches : public ::testing::TestWithParam<SimdTarget> {};
INSTANTIATE_TEST_SUITE_P(All, AllHitsBatches, ::testing::ValuesIn(simd_targets()), simd_label);

// Compares the query of many rays with that of each. Returns the largest number of crossings.
size_t expect_same_lists(const Accelerator& accelerator, std::span<const Ray> rays, size_t limit, int threads = 1) {
  CrossingLists lists;
  tbb::task_arena(threads).execute([&] { EXPECT_TRUE(all_hits(accelerator, rays, limit, lists)); });
  EXPECT_EQ(lists.ray_count(), rays.size());
  size_t max_count = 0, different = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const std::span<const Crossing> of_ray = lists.of(i);
    max_count = std::max(max_count, of_ray.size());
    different += crossings_of(accelerator, rays[i], limit) == std::vector(of_ray.begin(), of_ray.end()) ? 0 : 1;
  }
  EXPECT_EQ(different, 0U) << "of " << rays.size() << ", limit " << limit;
  return max_count;
}

// Streams, rays that are left to the single query, and limits on either side of where that is used
// for all.
TEST_P(AllHitsBatches, ManyRaysEqualSingleOnes) {
  std::deque<NamedScene> scenes = adversarial_scenes();
  for (NamedScene& named : hostile_scenes()) scenes.push_back(std::move(named));
  Rng rng(739);
  for (const NamedScene& named : scenes) {
    SCOPED_TRACE(named.name);
    const auto tested = build_all_hits(Kind::kdtree, named.scene, GetParam());
    std::vector<Ray> rays = hard_rays(rng, named.scene, static_cast<int>(trials("KINDLING_ALL_HITS_RAYS", 800)));
    rays[3].direction = V3f(0);
    rays[70].t_max = std::numeric_limits<float>::quiet_NaN();
    cut_at_hits(rng, *tested, std::span(rays).subspan(0, rays.size() / 4));
    for (const size_t limit : {kNoLimit, size_t{9}, size_t{7}}) expect_same_lists(*tested, rays, limit);
  }
}

TEST_P(AllHitsBatches, ManyRaysEqualSingleOnesOnRandomScenes) {
  const auto seeds = static_cast<uint32_t>(trials("KINDLING_ALL_HITS_SEEDS", 60));
  for (uint32_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const TestScene scene = seed % 4 == 0 ? random_motion(rng, 100) : random_scene(rng, 100);
    const std::vector<Ray> rays = aimed_rays(rng, scene, 200);
    expect_same_lists(*build_all_hits(Kind::kdtree, scene, GetParam()), rays, seed % 3 == 0 ? 8 : kNoLimit);
    if (HasFailure()) return;
  }
}

TEST_P(AllHitsBatches, RaysWithManyCrossings) {
  Rng rng(743);
  Mesh soup = triangle_soup(rng, 8000, 1.0f, 0.5f);
  soup.opaque = false;
  TestScene scene(soup);
  scene.set_filter({accept_even, nullptr, nullptr});
  const auto tested = build_all_hits(Kind::kdtree, scene, GetParam());
  const std::vector<Ray> rays = random_rays(rng, scene.bounds(), 1500);
  EXPECT_GT(expect_same_lists(*tested, rays, kNoLimit), 100U); // more than a stream keeps of a ray
  EXPECT_EQ(expect_same_lists(*tested, rays, 70), 70U);
  EXPECT_EQ(expect_same_lists(*tested, rays, 20), 20U);
}

TEST(AllHits, ManyRaysEqualSingleOnesForAnyNumberOfThreads) {
  Rng rng(733);
  const TestScene scene(triangle_soup(rng, 1000, 1.0f, 0.3f));
  const std::vector<Ray> rays = random_rays(rng, scene.bounds(), 3500);
  for (const Kind kind : {Kind::kdtree, Kind::embree}) {
    const auto accelerator = build_all_hits(kind, scene);
    for (const int threads : {1, 3}) expect_same_lists(*accelerator, rays, 50, threads);
  }
  CrossingLists lists;
  EXPECT_TRUE(all_hits(*build(Kind::kdtree, scene), {}, kNoLimit, lists));
  EXPECT_EQ(lists.ray_count(), 0U);
  EXPECT_FALSE(all_hits(*build(Kind::embree, scene), rays, kNoLimit, lists));
}

} // namespace
} // namespace kindling::accel::testing
