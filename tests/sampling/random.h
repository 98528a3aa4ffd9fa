// Pseudorandom numbers for tests, equal on every machine and not used by the renderer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>

namespace kindling::test {

// SplitMix64 (Steele, Lea and Flood 2014).
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  [[nodiscard]] uint64_t next_u64() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  // Returns a number in [0, 1), in multiples of 2^-24 like the renderer's sampler.
  [[nodiscard]] float next_1d() { return static_cast<float>(next_u64() >> 40) * 0x1p-24f; }
  [[nodiscard]] V2f next_2d() {
    const float x = next_1d();
    return {x, next_1d()};
  }
  [[nodiscard]] double next_double() { return static_cast<double>(next_u64() >> 11) * 0x1p-53; }

 private:
  uint64_t state_;
};

} // namespace kindling::test
