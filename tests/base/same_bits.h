// Comparison of lanes with single numbers, bit by bit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace kindling::test {

// Returns the bits, equal for all NaN: their sign and other bits are the processor's affair.
inline uint32_t comparable_bits(float x) { return x == x ? std::bit_cast<uint32_t>(x) : 0x7fc00000U; }

inline bool same_bits(float a, float b) { return comparable_bits(a) == comparable_bits(b); }
inline bool same_bits(const V2f& a, const V2f& b) { return same_bits(a.x, b.x) && same_bits(a.y, b.y); }
inline bool same_bits(const V3f& a, const V3f& b) {
  return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z);
}

inline float lane_of(const Lanes& x, size_t lane) { return x[lane]; }
inline V2f lane_of(const Imath::Vec2<Lanes>& v, size_t lane) { return {v.x[lane], v.y[lane]}; }
using kindling::lane_of; // of vectors

} // namespace kindling::test
