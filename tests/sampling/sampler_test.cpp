// Exact tests of the sampler: nets, stratification, and dependence on its arguments alone.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/sampler.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace kindling {
namespace {

constexpr uint32_t kSeeds[] = {0U, 1U, 77U, 0xffffffffU};
constexpr uint32_t kDimensions[] = {0U, 1U, 2U, 13U, 1000000U};

// The first 2^k points have exactly one in each elementary interval 2^-a by 2^-(k-a).
TEST(Sampler, PrefixesOfPowersOfTwoAreNets) {
  for (const uint32_t seed : kSeeds) {
    for (const uint32_t dimension : kDimensions) {
      const uint32_t key = Sampler(seed).pixel_key({3, 1000});
      for (uint32_t k = 0; k <= 12; ++k) {
        const uint32_t n = 1U << k;
        for (uint32_t a = 0; a <= k; ++a) {
          std::vector<bool> taken(n, false);
          for (uint32_t i = 0; i < n; ++i) {
            const V2f u = Sampler::sample_2d(key, i, dimension);
            const auto column = static_cast<uint32_t>(u.x * static_cast<float>(1U << a));
            const auto row = static_cast<uint32_t>(u.y * static_cast<float>(1U << (k - a)));
            const uint32_t cell = (column << (k - a)) | row;
            ASSERT_FALSE(taken[cell]) << "seed " << seed << " dimension " << dimension << " k " << k << " a " << a;
            taken[cell] = true;
          }
        }
      }
    }
  }
}

// Every later block of 2^k samples is a net as well, so resumed renders stay stratified.
TEST(Sampler, LaterBlocksAreNets) {
  const uint32_t key = Sampler(5).pixel_key({640, 2});
  for (const uint32_t first : {16U, 48U, 4096U, 0xfffffff0U}) {
    for (uint32_t a = 0; a <= 4; ++a) {
      std::vector<bool> taken(16, false);
      for (uint32_t i = 0; i < 16; ++i) {
        const V2f u = Sampler::sample_2d(key, first + i, 3);
        const uint32_t cell = (static_cast<uint32_t>(u.x * static_cast<float>(1U << a)) << (4 - a)) |
                              static_cast<uint32_t>(u.y * static_cast<float>(1U << (4 - a)));
        ASSERT_FALSE(taken[cell]);
        taken[cell] = true;
      }
    }
  }
}

TEST(Sampler, OneDimensionalPrefixesAreStratified) {
  for (const uint32_t seed : kSeeds) {
    for (const uint32_t dimension : kDimensions) {
      const uint32_t key = Sampler(seed).pixel_key({-1, 7});
      for (uint32_t k = 0; k <= 14; ++k) {
        std::vector<bool> taken(1U << k, false);
        for (uint32_t i = 0; i < (1U << k); ++i) {
          const float u = Sampler::sample_1d(key, i, dimension);
          const auto cell = static_cast<uint32_t>(u * static_cast<float>(1U << k));
          ASSERT_FALSE(taken[cell]);
          taken[cell] = true;
        }
      }
    }
  }
}

TEST(Sampler, SamplesAreInHalfOpenUnitInterval) {
  for (uint32_t i = 0; i < 2000000; ++i) {
    const V2f u = Sampler::sample_2d(i * 2654435761U, i, i & 31U);
    ASSERT_TRUE(u.x >= 0.0f && u.x < 1.0f && u.y >= 0.0f && u.y < 1.0f);
    const float v = Sampler::sample_1d(i * 2654435761U, i, i & 31U);
    ASSERT_TRUE(v >= 0.0f && v < 1.0f);
  }
}

TEST(Sampler, IsPureFunctionOfItsArguments) {
  const uint32_t key = Sampler(9).pixel_key({12, 34});
  EXPECT_EQ(key, Sampler(9).pixel_key({12, 34}));
  const V2f u = Sampler::sample_2d(key, 5, 6);
  for (uint32_t i = 0; i < 100; ++i) (void)Sampler::sample_2d(key, i, i);
  EXPECT_EQ(u, Sampler::sample_2d(key, 5, 6));
  EXPECT_NE(u, Sampler::sample_2d(key, 5, 7));
  EXPECT_NE(u, Sampler::sample_2d(key, 6, 6));
  EXPECT_NE(u, Sampler::sample_2d(Sampler(10).pixel_key({12, 34}), 5, 6));
  EXPECT_NE(u, Sampler::sample_2d(Sampler(9).pixel_key({34, 12}), 5, 6));
}

// Random keys of 32 bits collide: 2^20 of them in 2^40 / 2 / 2^32 = 128 pairs. Here pairs occur in
// pairs (two columns in two rows), so the standard deviation is 16.
TEST(Sampler, PixelKeysCollideNoMoreThanChance) {
  std::set<uint32_t> keys;
  for (int y = 0; y < 1024; ++y) {
    for (int x = 0; x < 1024; ++x) keys.insert(Sampler(0).pixel_key({x, y}));
  }
  const double collisions = 1024.0 * 1024.0 - static_cast<double>(keys.size());
  EXPECT_NEAR(collisions, 128.0, 5 * 16.0);
}

} // namespace
} // namespace kindling
