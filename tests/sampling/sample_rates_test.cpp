// Rates of samples: their counts by level, their cost, and what they depend on.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/allocate_samples.h"
#include "renderer/sampling/sample_rates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace kindling {
namespace {

TEST(SampleRates, PilotHasOneSampleOfEachPixel) {
  const SampleRates rates(V2i(8, 16), 2, {SampleRates::kMinRate, 16, 40, SampleRates::kMaxRate});
  for (const V2i& pixel : {V2i(8, 16), V2i(9, 16), V2i(8, 17), V2i(9, 17)})
    for (uint32_t level = 0; level <= SampleRates::kPilotLevels; ++level)
      EXPECT_EQ(rates.samples_before(pixel, level), level);
}

TEST(SampleRates, LevelsFollowEachOtherAndKeepTheRate) {
  for (uint32_t rate = SampleRates::kMinRate; rate <= SampleRates::kMaxRate; ++rate) {
    const SampleRates rates(V2i(0), 4, std::vector<uint8_t>(16, static_cast<uint8_t>(rate)));
    uint32_t next = SampleRates::kPilotLevels, of_block = 0;
    const uint32_t end = SampleRates::kPilotLevels + SampleRates::kUnit;
    for (int p = 0; p < 16; ++p) {
      const V2i pixel(p % 4, p / 4);
      next = SampleRates::kPilotLevels;
      for (uint32_t level = SampleRates::kPilotLevels; level < end; ++level) {
        const SampleRange samples = rates.samples_at(pixel, {level, level + 1});
        EXPECT_EQ(samples.first, next); // without a gap
        EXPECT_LE(samples.count(), SampleRates::kMaxRate / SampleRates::kUnit);
        next = samples.end;
      }
      // kUnit levels have the rate in whole samples, up to a group.
      EXPECT_EQ(next % SampleRates::kGroup, 0U);
      EXPECT_LT(std::abs(static_cast<int>(next) - static_cast<int>(SampleRates::kPilotLevels + rate)),
                static_cast<int>(SampleRates::kGroup));
      of_block += next - SampleRates::kPilotLevels;
    }
    EXPECT_EQ(of_block, 16 * rate); // sixteen pixels together have no rounding
  }
}

TEST(SampleRates, LevelsBeyondBillionsDoNotOverflow) {
  const SampleRates rates(V2i(0), 1, {SampleRates::kMaxRate});
  EXPECT_EQ(rates.samples_before(V2i(0), (1U << 29) + SampleRates::kPilotLevels),
            (1U << 31) + SampleRates::kPilotLevels);
}

double expected_rate(double variance, double cost, const RateRule& rule) {
  return std::clamp((rule.levels * rule.scale * std::sqrt(variance / cost) - 4.0) / (rule.levels - 4.0), 0.125, 4.0);
}

double cost_of(const std::vector<GroupNoise>& groups, const RateRule& rule) {
  double sum = 0.0;
  for (const GroupNoise& group : groups) sum += expected_rate(group.relative_variance, group.cost, rule) * group.cost;
  return sum;
}

TEST(RateRule, KeepsTheCost) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    std::vector<GroupNoise> groups(1 + random() % 300);
    double even = 0.0;
    for (GroupNoise& group : groups) {
      group.relative_variance = random() % 3 == 0 ? 0.0 : std::exp(static_cast<double>(random() % 1000) * 0.02 - 16.0);
      group.cost = 0.2 + static_cast<double>(random() % 100) * 0.2;
      even += group.cost;
    }
    const double levels = 5.0 + static_cast<double>(random() % 1000);
    const RateRule rule = rate_rule(groups, levels);
    if (rule.scale == 0.0) continue; // gains little
    const double max = cost_of(groups, {1e30, levels});
    EXPECT_NEAR(cost_of(groups, rule), std::min(even, max), 1e-6 * even);
  }
  EXPECT_EQ(rate_rule({}, 16.0).scale, 0.0);
  EXPECT_EQ(rate_rule(std::vector<GroupNoise>(3), 16.0).scale, 0.0);
}

NoiseMap random_map(const V2i& corner, int width, int height, uint32_t seed) {
  NoiseMap map{.corner = corner, .width = width, .height = height};
  std::mt19937 random(seed);
  for (int i = 0; i < width * height; ++i) {
    map.relative_variance.push_back(random() % 4 == 0 ? 0 : random() % (4U << 20));
    map.cost.push_back(0.2f + static_cast<float>(random() % 64));
  }
  return map;
}

TEST(RateRule, EvenNoiseHasEvenRates) {
  // Shares of 0.9 and 0.1 with variances of 1 and v gain (0.9 + 0.1 v) / (0.9 + 0.1 sqrt(v))^2.
  const auto scale_of = [](double variance) {
    std::vector<GroupNoise> groups(9, GroupNoise{1.0, 2.0});
    groups.push_back({variance, 2.0});
    return rate_rule(groups, 64.0).scale;
  };
  EXPECT_EQ(scale_of(1.0), 0.0);
  EXPECT_EQ(scale_of(4.0), 0.0);  // 1.074
  EXPECT_EQ(scale_of(8.0), 0.0);  // 1.215
  EXPECT_GT(scale_of(10.0), 0.0); // 1.285
  EXPECT_EQ(scale_of(0.01), 0.0); // 1.09
}

double slow_mean(const NoiseMap& map, const V2i& at, int radius) {
  double sum = 0.0;
  int count = 0;
  for (int y = std::max(at.y - radius, 0); y <= std::min(at.y + radius, map.height - 1); ++y)
    for (int x = std::max(at.x - radius, 0); x <= std::min(at.x + radius, map.width - 1); ++x) {
      if (V2i(x, y) == at) continue;
      sum += map.relative_variance[static_cast<size_t>(y * map.width + x)] * NoiseMap::kVarianceUnit;
      ++count;
    }
  return count == 0 ? 0.0 : sum / count;
}

TEST(AllocateSamples, FollowsTheNeighbors) {
  constexpr RateRule kRule{2.0, 20.0};
  const NoiseMap map = random_map(V2i(3, 5), 31, 22, 2);
  const std::vector<uint8_t> rates = allocate_samples(map, map.corner, map.width, map.height, kRule);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const auto i = static_cast<size_t>(y * map.width + x);
      const double variance = std::sqrt(slow_mean(map, V2i(x, y), 2) * slow_mean(map, V2i(x, y), 6));
      const double rate = expected_rate(variance, static_cast<double>(map.cost[i]), kRule);
      EXPECT_NEAR(rates[i], rate * SampleRates::kUnit, 0.5 + 1e-6) << x << ", " << y;
    }
}

TEST(AllocateSamples, NotOnThePixelItself) {
  NoiseMap map = random_map(V2i(0), 20, 20, 3);
  const uint8_t before = allocate_samples(map, V2i(7, 9), 1, 1, {1.5, 64.0})[0];
  map.relative_variance[9 * 20 + 7] = 0;
  EXPECT_EQ(allocate_samples(map, V2i(7, 9), 1, 1, {1.5, 64.0})[0], before);
  std::fill(map.relative_variance.begin(), map.relative_variance.end(), 0);
  map.relative_variance[9 * 20 + 7] = 4U << 20; // the only noise
  const std::vector<uint8_t> rates = allocate_samples(map, V2i(0), 20, 20, {1e3, 64.0});
  EXPECT_EQ(rates[9 * 20 + 7], SampleRates::kMinRate);
  EXPECT_EQ(rates[9 * 20 + 8], SampleRates::kMaxRate);
}

TEST(AllocateSamples, NotOnThePartThatIsRendered) {
  const NoiseMap whole = random_map(V2i(0), 40, 30, 4);
  const std::vector<uint8_t> rates = allocate_samples(whole, V2i(0), 40, 30, {1.0, 64.0});
  // A part of the map with as much around the rectangle as rates may depend on.
  NoiseMap part{.corner = V2i(4, 0), .width = 27, .height = 19};
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) {
      part.relative_variance.push_back(whole.relative_variance[static_cast<size_t>(y * 40 + x + 4)]);
      part.cost.push_back(whole.cost[static_cast<size_t>(y * 40 + x + 4)]);
    }
  const V2i corner(4 + kAllocationMargin, 0);
  const int width = part.width - 2 * kAllocationMargin, height = part.height - kAllocationMargin;
  const std::vector<uint8_t> found = allocate_samples(part, corner, width, height, {1.0, 64.0});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      EXPECT_EQ(found[static_cast<size_t>(y * width + x)], rates[static_cast<size_t>(y * 40 + corner.x + x)]);
}

} // namespace
} // namespace kindling
