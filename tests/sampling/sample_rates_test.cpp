// Numbers of samples: by level, their cost, and what they depend on.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/allocate_samples.h"
#include "renderer/sampling/sample_rates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace kindling {
namespace {

TEST(SampleRates, PilotHasOneSampleOfEachPixel) {
  const SampleRates rates(V2i(8, 16), 2, 16, {2, 3, 5, 6});
  for (const V2i& pixel : {V2i(8, 16), V2i(9, 16), V2i(8, 17), V2i(9, 17)})
    for (uint32_t level = 0; level <= SampleRates::kPilotLevels; ++level)
      EXPECT_EQ(rates.samples_before(pixel, level), level);
}

TEST(SampleRates, NumbersAreWithinTheirBounds) {
  EXPECT_EQ(SampleRates::min_log2(5), 2U); // the pilot
  EXPECT_EQ(SampleRates::max_log2(5), 3U); // the pilot and what one level takes
  EXPECT_EQ(SampleRates::min_log2(16), 2U);
  EXPECT_EQ(SampleRates::max_log2(16), 6U);
  EXPECT_EQ(SampleRates::min_log2(64), 3U);
  EXPECT_EQ(SampleRates::max_log2(64), 8U);
  EXPECT_EQ(SampleRates::max_log2(100), 8U); // not 400
  EXPECT_EQ(SampleRates::max_log2(1U << 30), 31U);
}

// Levels follow each other without a gap; before the planned one a pixel has its number.
TEST(SampleRates, LevelsEndAtPowersOfTwo) {
  for (const uint32_t planned : {5U, 6U, 13U, 16U, 64U, 100U})
    for (uint32_t log2 = SampleRates::min_log2(planned); log2 <= SampleRates::max_log2(planned); ++log2) {
      const SampleRates rates(V2i(0), 4, planned, std::vector<uint8_t>(16, static_cast<uint8_t>(log2)));
      for (int p = 0; p < 16; ++p) {
        const V2i pixel(p % 4, p / 4);
        uint32_t next = 0;
        for (uint32_t level = 0; level < planned; ++level) {
          const SampleRange samples = rates.samples_at(pixel, {level, level + 1});
          EXPECT_EQ(samples.first, next);
          EXPECT_LE(samples.count(), SampleRates::kMaxAtLevel);
          if (level >= SampleRates::kPilotLevels) {
            EXPECT_EQ(samples.count() % SampleRates::kGroup, 0U);
          }
          next = samples.end;
        }
        EXPECT_EQ(next, 1U << log2) << planned;
        EXPECT_EQ(rates.planned_samples(pixel), 1U << log2);
        // Further levels take as many.
        const uint32_t round = planned - SampleRates::kPilotLevels;
        EXPECT_EQ(rates.samples_before(pixel, planned + 2 * round), (1U << log2) + 2 * ((1U << log2) - 4U));
      }
    }
}

// Sixteen pixels together take samples evenly.
TEST(SampleRates, PixelsOfABlockWaitForDifferentLevels) {
  const SampleRates rates(V2i(0), 4, 64, std::vector<uint8_t>(16, 6));
  for (uint32_t level = SampleRates::kPilotLevels; level < 64; ++level) {
    uint32_t taken = 0;
    for (int p = 0; p < 16; ++p) taken += rates.samples_at(V2i(p % 4, p / 4), {level, level + 1}).count();
    EXPECT_EQ(taken, 16U) << level;
  }
}

TEST(SampleRates, LevelsBeyondBillionsDoNotOverflow) {
  const SampleRates rates(V2i(0), 1, 16, {6});
  uint32_t before = 0;
  for (const uint32_t level : {1U << 20, 1U << 29, 1U << 30, 1U << 31, UINT32_MAX}) {
    EXPECT_GE(rates.samples_before(V2i(0), level), before);
    before = rates.samples_before(V2i(0), level);
  }
  EXPECT_EQ(before, UINT32_MAX);
}

// The nearest power of two within the bounds.
double expected_samples(double variance, double cost, uint32_t planned, double scale) {
  const double log2 = std::round(std::log2(planned * scale * std::sqrt(variance / cost)));
  return std::exp2(std::clamp(log2, static_cast<double>(SampleRates::min_log2(planned)),
                              static_cast<double>(SampleRates::max_log2(planned))));
}

double cost_of(const std::vector<GroupNoise>& groups, uint32_t planned, double scale) {
  double sum = 0.0;
  for (const GroupNoise& group : groups)
    sum += expected_samples(group.relative_variance, group.cost, planned, scale) * group.cost;
  return sum;
}

// Numbers are powers of two, so the cost is met up to the step of one group.
TEST(RateScale, KeepsTheCost) {
  std::mt19937 random(1);
  int used = 0;
  for (int i = 0; i < 200; ++i) {
    std::vector<GroupNoise> groups(1 + random() % 300);
    double even = 0.0;
    for (GroupNoise& group : groups) {
      group.relative_variance = random() % 3 == 0 ? 0.0 : std::exp(static_cast<double>(random() % 1000) * 0.02 - 16.0);
      group.cost = 0.2 + static_cast<double>(random() % 100) * 0.2;
      even += group.cost;
    }
    const uint32_t planned = 5 + random() % 1000;
    double predicted = 0.0;
    const double scale = rate_scale(groups, planned, 1.25, predicted);
    EXPECT_EQ(scale > 0.0, predicted < 1.0 / 1.25);
    if (scale == 0.0) continue; // gains little
    ++used;
    const double max = cost_of(groups, planned, 1e30);
    const double wanted = 0.9 * even * planned;
    EXPECT_GE(cost_of(groups, planned, scale * (1.0 + 1e-9)), std::min(wanted, max) * (1.0 - 1e-12));
    EXPECT_LT(cost_of(groups, planned, scale * (1.0 - 1e-9)), wanted);
  }
  EXPECT_GT(used, 100);
}

TEST(RateScale, EvenNoiseHasEvenNumbers) {
  double predicted = 0.0;
  EXPECT_EQ(rate_scale({}, 16, 1.25, predicted), 0.0);
  EXPECT_EQ(predicted, 1.0);
  EXPECT_EQ(rate_scale(std::vector<GroupNoise>(3), 16, 0.0, predicted), 0.0); // no noise at all
  // Shares of 0.9 and 0.1 with variances of 1 and v gain (0.9 + 0.1 v) / (0.9 + 0.1 sqrt(v))^2.
  const auto scale_of = [&](double variance) {
    std::vector<GroupNoise> groups(9, GroupNoise{1.0, 2.0});
    groups.push_back({variance, 2.0});
    return rate_scale(groups, 64, 1.25, predicted);
  };
  EXPECT_EQ(scale_of(1.0), 0.0);
  EXPECT_EQ(scale_of(4.0), 0.0);  // 1.074
  EXPECT_EQ(scale_of(8.0), 0.0);  // 1.215
  EXPECT_GT(scale_of(10.0), 0.0); // 1.285
  EXPECT_NEAR(1.0 / predicted, 1.9 / std::pow(0.9 + 0.1 * std::sqrt(10.0), 2.0), 1e-12);
  EXPECT_EQ(scale_of(0.01), 0.0); // 1.09
}

TEST(RelativeVariance, CountsDarkPixelsByTheFloor) {
  EXPECT_EQ(relative_variance(2.0, 1.0, 0.0), 0.25);
  EXPECT_EQ(relative_variance(0.0, 1.0, 2.0), 0.25);
  EXPECT_EQ(relative_variance(0.0, 0.0, 0.0), 0.0);
  EXPECT_EQ(relative_variance(0.25, 1.0, 0.0), 4.0); // at most that of one bright sample of four
  EXPECT_EQ(relative_variance(1e30, std::numeric_limits<double>::quiet_NaN(), 0.0), 4.0);
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
  constexpr RateRule kRule{2.0, 0.0};
  const NoiseMap map = random_map(V2i(3, 5), 31, 22, 2);
  const std::vector<uint8_t> numbers = allocate_samples(map, map.corner, map.width, map.height, 20, kRule);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const auto i = static_cast<size_t>(y * map.width + x);
      const double variance = std::sqrt(slow_mean(map, V2i(x, y), 2) * slow_mean(map, V2i(x, y), 6));
      EXPECT_EQ(1U << numbers[i], expected_samples(variance, static_cast<double>(map.cost[i]), 20, kRule.scale))
          << x << ", " << y;
    }
}

TEST(AllocateSamples, NotOnThePixelItself) {
  NoiseMap map = random_map(V2i(0), 20, 20, 3);
  const uint8_t before = allocate_samples(map, V2i(7, 9), 1, 1, 64, {1.5, 0.0})[0];
  map.relative_variance[9 * 20 + 7] = 0;
  EXPECT_EQ(allocate_samples(map, V2i(7, 9), 1, 1, 64, {1.5, 0.0})[0], before);
  std::fill(map.relative_variance.begin(), map.relative_variance.end(), 0);
  map.relative_variance[9 * 20 + 7] = 4U << 20; // the only noise
  const std::vector<uint8_t> numbers = allocate_samples(map, V2i(0), 20, 20, 64, {1e3, 0.0});
  EXPECT_EQ(numbers[9 * 20 + 7], SampleRates::min_log2(64));
  EXPECT_EQ(numbers[9 * 20 + 8], SampleRates::max_log2(64));
}

TEST(AllocateSamples, NotOnThePartThatIsRendered) {
  const NoiseMap whole = random_map(V2i(0), 40, 30, 4);
  const std::vector<uint8_t> rates = allocate_samples(whole, V2i(0), 40, 30, 64, {1.0, 0.0});
  // A part of the map with as much around the rectangle as rates may depend on.
  NoiseMap part{.corner = V2i(4, 0), .width = 27, .height = 19};
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) {
      part.relative_variance.push_back(whole.relative_variance[static_cast<size_t>(y * 40 + x + 4)]);
      part.cost.push_back(whole.cost[static_cast<size_t>(y * 40 + x + 4)]);
    }
  const V2i corner(4 + kAllocationMargin, 0);
  const int width = part.width - 2 * kAllocationMargin, height = part.height - kAllocationMargin;
  const std::vector<uint8_t> found = allocate_samples(part, corner, width, height, 64, {1.0, 0.0});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      EXPECT_EQ(found[static_cast<size_t>(y * width + x)], rates[static_cast<size_t>(y * 40 + corner.x + x)]);
}

} // namespace
} // namespace kindling
