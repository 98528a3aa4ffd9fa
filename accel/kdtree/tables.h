// Lookup tables that replace branches in steps through nodes and in compression.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/deforming/moving_node.h"

#include <array>
#include <cstdint>

namespace kindling::accel::kd {

namespace tables {

// Maps comparisons of the entry point with the planes (bit set: above) to the lane of the child
// that contains it. Bit 2 is ignored.
consteval std::array<uint8_t, 256> make_near_lane() {
  std::array<uint8_t, 256> table{};
  for (uint32_t bits = 0; bits < 256; ++bits) {
    const uint32_t first = (bits >> kRootLane) & 1;
    const uint32_t second = (bits >> (kSecondLane + first)) & 1;
    const uint32_t third = (bits >> (kThirdLane + 2 * first + second)) & 1;
    table[bits] = static_cast<uint8_t>(4 * first + 2 * second + third);
  }
  return table;
}

// Maps the signs of the direction along the axes of the planes to eight bytes, one per child from
// far to near: the lane in bits 0 to 2, the lane of its third-level plane in bits 3 to 5, that of
// its second-level plane in bits 6 and 7.
consteval std::array<uint64_t, 256> make_order() {
  std::array<uint64_t, 256> table{};
  for (uint32_t signs = 0; signs < 256; ++signs) {
    for (uint32_t position = 0; position < kWideLanes; ++position) {
      const uint32_t far1 = position < 4, far2 = (position & 2) == 0, far3 = (position & 1) == 0;
      const uint32_t first = far1 ^ ((signs >> kRootLane) & 1);
      const uint32_t plane2 = kSecondLane + first;
      const uint32_t second = far2 ^ ((signs >> plane2) & 1);
      const uint32_t plane3 = kThirdLane + 2 * first + second;
      const uint32_t third = far3 ^ ((signs >> plane3) & 1);
      const uint64_t entry = (4 * first + 2 * second + third) | ((plane3 & 7) << 3) | (plane2 << 6);
      table[signs] |= entry << (8 * position);
    }
  }
  return table;
}

// Maps a mask to eight bytes: the indices of the set bits, then zeros.
consteval std::array<uint64_t, 256> make_compress() {
  std::array<uint64_t, 256> table{};
  for (uint32_t mask = 0; mask < 256; ++mask) {
    uint32_t count = 0;
    for (uint32_t bit = 0; bit < 8; ++bit)
      if ((mask >> bit) & 1) table[mask] |= static_cast<uint64_t>(bit) << (8 * count++);
  }
  return table;
}

inline constexpr std::array<uint8_t, 256> kNearLane = make_near_lane();
inline constexpr std::array<uint64_t, 256> kOrder = make_order();
// The table of make_order() with children from near to far.
consteval std::array<uint64_t, 256> make_near_first() {
  std::array<uint64_t, 256> table{};
  const std::array<uint64_t, 256> far_first = make_order();
  for (uint32_t signs = 0; signs < 256; ++signs)
    for (uint32_t position = 0; position < kWideLanes; ++position)
      table[signs] |= ((far_first[signs] >> (8 * position)) & 0xffU) << (8 * (kWideLanes - 1 - position));
  return table;
}
inline constexpr std::array<uint64_t, 256> kNearFirst = make_near_first();
inline constexpr std::array<uint64_t, 256> kCompress = make_compress();

} // namespace tables

} // namespace kindling::accel::kd
