// ASTC's sequences of small integers with trits or quints, and their unquantization.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/image/blocks/texel_block.h"

namespace kindling::image_detail {

// The storage of an integer below `levels`: `bits` bits, and above these a trit (base 3), a quint
// (base 5) or nothing (base 1) (Khronos Data Format Specification 1.3, 23.12).
struct AstcRange {
  uint8_t base;
  uint8_t bits;

  [[nodiscard]] constexpr uint32_t levels() const { return static_cast<uint32_t>(base) << bits; }
};

// All ranges of ASTC in rising order, from 2 to 256 levels. Weights use the first 12, endpoints all
// from the fifth (6 levels) on.
constexpr std::array<AstcRange, 21> kAstcRanges = {{{1, 1}, {3, 0}, {1, 2}, {5, 0}, {3, 1}, {1, 3}, {5, 1},
                                                    {3, 2}, {1, 4}, {5, 2}, {3, 3}, {1, 5}, {5, 3}, {3, 4},
                                                    {1, 6}, {5, 4}, {3, 5}, {1, 7}, {5, 5}, {3, 6}, {1, 8}}};

// Returns the length of a sequence in bits.
[[nodiscard]] constexpr uint32_t astc_sequence_bits(AstcRange range, uint32_t count) {
  const uint32_t high = range.base == 3 ? (8 * count + 4) / 5 : range.base == 5 ? (7 * count + 2) / 3 : 0;
  return high + count * range.bits;
}

constexpr size_t kMaxAstcIntegers = 64;
using AstcIntegers = std::array<uint32_t, kMaxAstcIntegers>;

// Reads `count` integers from bit `first` of the block on, each `bits` bits low and its trit or
// quint above.
void read_astc_integers(const BitField& block, uint32_t first, AstcRange range, uint32_t count, AstcIntegers& integers);

// Returns an endpoint value as 0 to 255 (23.13).
[[nodiscard]] uint32_t astc_color_value(AstcRange range, uint32_t integer);

// Returns a weight as 0 to 64 (23.17).
[[nodiscard]] uint32_t astc_weight_value(AstcRange range, uint32_t integer);

} // namespace kindling::image_detail
