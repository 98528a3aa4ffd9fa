// The shuffled order names each number once, and is not the obvious one.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/shuffled_numbers.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace kindling::test {
namespace {

TEST(ShuffledNumbers, NameEachNumberOnce) {
  for (const uint32_t count : {1U, 2U, 3U, 4U, 5U, 7U, 8U, 63U, 64U, 65U, 1000U, 65536U, 65537U}) {
    for (const uint32_t seed : {0U, 1U, 0xdeadbeefU}) {
      const ShuffledNumbers numbers(count, seed);
      std::vector<uint32_t> seen(count, 0);
      for (uint32_t i = 0; i < count; ++i) {
        ASSERT_LT(numbers[i], count);
        ++seen[numbers[i]];
      }
      for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(seen[i], 1U) << i << " of " << count;
    }
  }
}

// In a random permutation of n numbers, n / 2 of the steps on average are upwards, with a standard
// deviation of sqrt((n + 1) / 12) (Eulerian numbers); one number stays in its place on average.
TEST(ShuffledNumbers, AreInNoOrder) {
  constexpr uint32_t kCount = 100000;
  for (const uint32_t seed : {1U, 2U, 3U}) {
    const ShuffledNumbers numbers(kCount, seed);
    uint32_t upwards = 0, in_place = 0;
    for (uint32_t i = 0; i < kCount; ++i) {
      if (i > 0 && numbers[i] > numbers[i - 1]) ++upwards;
      if (numbers[i] == i) ++in_place;
    }
    EXPECT_NEAR(upwards, kCount / 2, 5 * 91) << "seed " << seed;
    EXPECT_LT(in_place, 20U) << "seed " << seed;
  }
}

} // namespace
} // namespace kindling::test
