// Integer hashes for sampling and stochastic decisions, with equal results on every machine.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

namespace kindling {

// Mixes 32 bits with low bias; a bijection (Wellons 2018, "Prospecting for Hash Functions":
// lowbias32).
[[nodiscard]] inline constexpr uint32_t hash_u32(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  x ^= x >> 16;
  return x;
}

[[nodiscard]] inline constexpr uint32_t hash_combine(uint32_t seed, uint32_t value) {
  return hash_u32(seed ^ (value + 0x9e3779b9U + (seed << 6) + (seed >> 2)));
}

// Maps the high 24 bits uniformly to [0, 1).
[[nodiscard]] inline constexpr float to_unit_float(uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

} // namespace kindling
