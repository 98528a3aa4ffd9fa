// Tests of the jittered sampler: stratification, uniform permutations and independent draws.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/jittered.h"

#include "renderer/sampling/bounce_draws.h"
#include "renderer/sampling/draw_eight.h"
#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

#include <map>

namespace kindling {
namespace {

using jittered::Strata;
using jittered::strata_for;

TEST(Jittered, GridsAreSquareIfPossible) {
  const auto expect = [](uint32_t samples, uint32_t columns, uint32_t rows) {
    const Strata strata = strata_for(samples);
    EXPECT_EQ(strata.columns, columns) << samples;
    EXPECT_EQ(strata.rows, rows) << samples;
  };
  for (const uint32_t n : {1U, 2U, 3U, 7U, 16U, 45U, 1024U, 32768U}) expect(n * n, n, n);
  expect(2, 1, 2);
  expect(6, 2, 3);
  expect(12, 3, 4);
  expect(32, 4, 8);
  expect(7, 3, 3); // two cells stay empty
  expect(13, 4, 4);
  expect(0xffffffffU, 32768, 32768);
  for (uint32_t samples = 1; samples < 3000; ++samples) {
    const Strata strata = strata_for(samples);
    EXPECT_GE(strata.count(), samples);
    EXPECT_LE(strata.count() - samples, strata.columns) << samples;
    EXPECT_LE(strata.rows, 2 * strata.columns) << samples;
  }
}

TEST(Jittered, PermuteIsBijective) {
  for (const uint32_t count : {1U, 2U, 3U, 9U, 16U, 17U, 100U, 1000U})
    for (uint32_t seed = 0; seed < 20; ++seed) {
      std::vector<int> seen(count, 0);
      for (uint32_t i = 0; i < count; ++i) ++seen[jittered::permute(i, count, seed * 7919U)];
      EXPECT_EQ(seen, std::vector<int>(count, 1)) << count << " " << seed;
    }
}

// Over many seeds, all ordered pairs of cells of two samples are equally frequent.
TEST(Jittered, PairsOfCellsAreEquallyFrequent) {
  const std::array<uint32_t, 7> counts{2, 3, 4, 6, 9, 16, 25};
  const double level = test::sidak_level(0.01, 3 * static_cast<int>(counts.size()));
  for (const uint32_t count : counts)
    for (const auto& [first, second] : {std::pair{0U, 1U}, std::pair{0U, count - 1}, std::pair{count / 2, count - 1}}) {
      if (first == second) continue;
      std::map<std::pair<uint32_t, uint32_t>, double> observed;
      constexpr uint32_t kSeeds = 40000;
      for (uint32_t seed = 0; seed < kSeeds; ++seed) {
        const uint32_t key = hash_u32(seed + count * 977U + first);
        ++observed[{jittered::permute(first, count, key), jittered::permute(second, count, key)}];
      }
      const double pairs = count * (count - 1.0), expected = kSeeds / pairs;
      double statistic = (pairs - static_cast<double>(observed.size())) * expected; // pairs that never occurred
      for (const auto& [cells, n] : observed) {
        EXPECT_NE(cells.first, cells.second);
        statistic += (n - expected) * (n - expected) / expected;
      }
      if (pairs > 1.0) {
        EXPECT_GT(test::chi_square_tail(statistic, static_cast<int>(pairs) - 1), level)
            << count << ": " << first << " and " << second << ", " << statistic;
      }
    }
}

TEST(Jittered, EachCellHasOneSample) {
  for (const uint32_t spp : {1U, 4U, 9U, 12U, 25U, 64U}) {
    const Strata strata = strata_for(spp);
    for (const uint32_t block : {0U, 1U, 5U}) { // also beyond the planned number of samples
      const Sampler sampler(3, SamplerKind::jittered, spp);
      std::array<std::vector<int>, 3> cells_2d;
      std::array<std::vector<int>, 3> cells_1d;
      for (auto* cells : {&cells_2d, &cells_1d})
        for (auto& one : *cells) one.assign(spp, 0);
      for (uint32_t i = block * spp; i < (block + 1) * spp; ++i) {
        const SampleAddress address = sampler.address({17, 40}, i);
        const BounceDraws u = draw_bounce(address, 8);
        const auto count_2d = [&](size_t k, const V2f& p) {
          const auto column = static_cast<uint32_t>(p.x * static_cast<float>(strata.columns));
          const auto row = static_cast<uint32_t>(p.y * static_cast<float>(strata.rows));
          ++cells_2d[k].at(row * strata.columns + column);
        };
        const auto count_1d = [&](size_t k, float x) {
          ++cells_1d[k].at(static_cast<size_t>(x * static_cast<float>(spp)));
        };
        count_2d(0, Sampler::sample_2d(address, 0));
        count_2d(1, u.direction);
        count_2d(2, u.light);
        count_1d(0, Sampler::sample_1d(address, 2));
        count_1d(1, u.roulette);
        count_1d(2, u.spare);
      }
      for (size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(cells_2d[k], std::vector<int>(spp, 1)) << spp << " draw " << k;
        EXPECT_EQ(cells_1d[k], std::vector<int>(spp, 1)) << spp << " draw " << k;
      }
    }
  }
}

// Over many pixels, each single sample is uniform, even if some cells stay empty.
TEST(Jittered, EachSampleIsUniform) {
  const double level = test::sidak_level(0.01, 8);
  constexpr int kGrid = 24, kPixels = 60000;
  for (const uint32_t spp : {9U, 7U})
    for (const uint32_t index : {0U, spp - 1}) {
      const Sampler sampler(5, SamplerKind::jittered, spp);
      std::vector<double> observed(kGrid * kGrid, 0.0), observed_1d(kGrid * kGrid, 0.0);
      for (int p = 0; p < kPixels; ++p) {
        const SampleAddress address = sampler.address({p % 300, p / 300}, index);
        const V2f u = Sampler::sample_2d(address, 3);
        ++observed[static_cast<size_t>(u.y * kGrid) * kGrid + static_cast<size_t>(u.x * kGrid)];
        ++observed_1d[static_cast<size_t>(Sampler::sample_1d(address, 4) * (kGrid * kGrid))];
      }
      for (const auto* counts : {&observed, &observed_1d}) {
        const double expected = static_cast<double>(kPixels) / (kGrid * kGrid);
        double statistic = 0.0;
        for (const double n : *counts) statistic += (n - expected) * (n - expected) / expected;
        EXPECT_GT(test::chi_square_tail(statistic, kGrid * kGrid - 1), level)
            << spp << " " << index << ": " << statistic;
      }
    }
}

// The cells of two draws of a sample are independent.
TEST(Jittered, DrawsAreIndependentOfEachOther) {
  const Sampler sampler(6, SamplerKind::jittered, 9);
  std::vector<double> observed(81, 0.0);
  constexpr int kPixels = 8100;
  for (int p = 0; p < kPixels; ++p)
    for (uint32_t i = 0; i < 9; ++i) {
      const SampleAddress address = sampler.address({p % 90, p / 90}, i);
      const V2f a = Sampler::sample_2d(address, 0), b = draw_bounce(address, 8).direction;
      const auto cell = [](const V2f& u) {
        return static_cast<size_t>(u.y * 3.0f) * 3 + static_cast<size_t>(u.x * 3.0f);
      };
      ++observed[cell(a) * 9 + cell(b)];
    }
  // The 9 pairs of a pixel are a random permutation: a count has the variance 8 / 81 for each
  // pixel, so Pearson's statistic has the mean 81 (8 / 9), spread over 64 degrees of freedom.
  const double expected = kPixels / 9.0;
  double statistic = 0.0;
  for (const double n : observed) statistic += (n - expected) * (n - expected) / expected;
  EXPECT_GT(test::chi_square_tail(statistic * 8.0 / 9.0, 64), 1e-3) << statistic;
  EXPECT_GT(1.0 - test::chi_square_tail(statistic * 8.0 / 9.0, 64), 1e-3) << statistic;
}

TEST(Jittered, VectorDrawsMatchSingleDraws) {
  const Sampler sampler(7, SamplerKind::jittered, 12);
  std::array<SampleAddress, 8> addresses;
  for (uint32_t i = 0; i < 8; ++i) addresses[i] = sampler.address({3, 4}, i);
  const Imath::Vec2<Lanes> draws = draw_eight(addresses, 0);
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(V2f(draws.x[i], draws.y[i]), Sampler::sample_2d(addresses[i], 0));
    const BounceDraws u = draw_bounce(addresses[i], 16);
    EXPECT_EQ(u.choice, Sampler::sample_2d(addresses[i], 16));
    EXPECT_EQ(u.light, Sampler::sample_2d(addresses[i], 17));
  }
}

} // namespace
} // namespace kindling
