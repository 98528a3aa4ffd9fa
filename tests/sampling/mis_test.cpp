// Tests of the power heuristic: weights add up to one for all pairs of densities.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/mis.h"

#include "tests/base/same_bits.h"

#include <gtest/gtest.h>

#include <iterator>
#include <limits>

namespace kindling {
namespace {

TEST(Mis, MatchesFormula) {
  EXPECT_FLOAT_EQ(power_heuristic(1.0f, 1.0f), 0.5f);
  EXPECT_FLOAT_EQ(power_heuristic(3.0f, 1.0f), 0.9f);
  EXPECT_FLOAT_EQ(power_heuristic(1.0f, 3.0f), 0.1f);
}

TEST(Mis, WeightsAddUpToOneForAllMagnitudes) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const float values[] = {0.0f, 1e-45f, 1e-38f, 1e-20f, 1e-3f, 1.0f, 7.5f, 1e19f, 1e30f, 3.4e38f, kInf};
  for (const float a : values) {
    for (const float b : values) {
      const float w = power_heuristic(a, b);
      ASSERT_TRUE(w >= 0.0f && w <= 1.0f) << a << " " << b;
      if (a > 0.0f || b > 0.0f) {
        EXPECT_NEAR(w + power_heuristic(b, a), 1.0f, 1e-6f) << a << " " << b;
      }
    }
  }
  EXPECT_EQ(power_heuristic(0.0f, 0.0f), 0.0f);
  EXPECT_EQ(power_heuristic(kInf, 1.0f), 1.0f);
  EXPECT_EQ(power_heuristic(1.0f, kInf), 0.0f);
}

TEST(Mis, EightWeightsHaveTheBitsOfEachAlone) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const float values[] = {0.0f, 1e-45f, 1e-38f, 1e-20f, 1e-3f, 1.0f, 7.5f, 1e19f, 1e30f, 3.4e38f, kInf};
  constexpr size_t kPairs = std::size(values) * std::size(values);
  for (size_t first = 0; first < kPairs; ++first) {
    LaneNumbers a, b;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const size_t pair = (first + lane * 17) % kPairs; // neighbors differ
      a[lane] = values[pair / std::size(values)], b[lane] = values[pair % std::size(values)];
    }
    const Lanes weights = power_heuristic(a.load(), b.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane)
      ASSERT_TRUE(test::same_bits(weights[lane], power_heuristic(a[lane], b[lane]))) << a[lane] << " " << b[lane];
  }
}

} // namespace
} // namespace kindling
