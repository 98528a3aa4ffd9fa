// The numbers from 0 to n - 1 in a pseudo-random order, without a table.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"

#include <bit>
#include <cassert>
#include <cstdint>

namespace kindling {

// A bijection on the next power of two. Numbers beyond the count are mapped again, until they are
// below it: at most twice on average.
class ShuffledNumbers {
 public:
  ShuffledNumbers(uint32_t count, uint32_t seed)
      : count_(count), mask_(std::bit_ceil(count) - 1), half_((static_cast<uint32_t>(std::bit_width(mask_)) + 1) / 2),
        seed_(seed) {
    assert(count > 0 && count <= 1U << 31);
  }

  [[nodiscard]] uint32_t operator[](uint32_t i) const {
    assert(i < count_);
    do i = shuffled(i);
    while (i >= count_);
    return i;
  }

 private:
  // Each step can be undone: sums, products with odd numbers and shifted differences modulo the
  // power of two.
  [[nodiscard]] uint32_t shuffled(uint32_t x) const {
    for (uint32_t round = 0; round < 3; ++round) {
      const uint32_t key = hash_combine(seed_, round);
      x = ((x + key) * (key | 1U)) & mask_;
      x ^= x >> half_;
    }
    return x;
  }

  uint32_t count_, mask_, half_, seed_;
};

} // namespace kindling
