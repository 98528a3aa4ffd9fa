// Fuzz test of random scenes, builds and rays against the oracle.
//
// Each seed makes one scene, built and traced in one configuration. KINDLING_FUZZ_SEEDS=100000 sets
// the number of seeds, KINDLING_FUZZ_FIRST=17 the first one; failures print their seed.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/fuzz_scenes.h"
#include "tests/accel/trials.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <iostream>

namespace kindling::accel::testing {
namespace {

class Fuzz : public ::testing::TestWithParam<SimdTarget> {};

TEST_P(Fuzz, AgreesWithBruteForce) {
  const auto first = static_cast<uint32_t>(number_from_environment("KINDLING_FUZZ_FIRST", 1));
  const auto count =
      static_cast<uint32_t>(trials("KINDLING_FUZZ_SEEDS", GetParam() == best_simd_target() ? 2000 : 400));
  size_t rays = 0, hits = 0, failed_seeds = 0;
  for (uint32_t seed = first; seed < first + count && failed_seeds < 5; ++seed) {
    Rng rng(seed);
    const TestScene scene = random_scene(rng, seed % 16 == 0 ? 3000 : 200);
    BuildOptions options;
    options.simd = GetParam();
    options.quality = static_cast<Quality>(rng() % 3);
    const int threads = 1 + static_cast<int>(rng() % 4);
    std::unique_ptr<Accelerator> tested;
    tbb::task_arena arena(threads);
    arena.execute([&] { tested = build(Kind::kdtree, scene, options); });
    const auto oracle = build(Kind::brute_force, scene);
    std::vector<Ray> some = aimed_rays(rng, scene, 200);
    cut_at_hits(rng, *oracle, some);
    Comparison comparison;
    compare(*oracle, *tested, some, 1 + rng() % 100, comparison);
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

INSTANTIATE_TEST_SUITE_P(All, Fuzz, ::testing::ValuesIn(simd_targets()), simd_label);

} // namespace
} // namespace kindling::accel::testing
