// Lookup tables that replace branches in compression.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace kindling::accel::kd {

namespace tables {

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

inline constexpr std::array<uint64_t, 256> kCompress = make_compress();

} // namespace tables

} // namespace kindling::accel::kd
