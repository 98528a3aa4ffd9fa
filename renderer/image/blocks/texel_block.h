// Texels of one block of a compressed image, and the bits of a block.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling::image_detail {

using BlockBytes = std::span<const std::byte>;

// RGBA of up to 12 x 12 texels, row after row from the top, each row as wide as the block. The
// format determines the unit of a channel: 8 or 16 bits of an unsigned fraction, or the bits of a
// half or float. Decoders write all four channels; missing ones are 0, missing alpha is 1.
constexpr size_t kMaxBlockTexels = 144;
using Texel = std::array<uint32_t, 4>;
using TexelBlock = std::array<Texel, kMaxBlockTexels>;

// The bits of a block of 8 or 16 bytes, numbered from the lowest bit of the first byte.
class BitField {
 public:
  explicit BitField(BlockBytes bytes) {
    assert(bytes.size() == 8 || bytes.size() == 16);
    for (size_t i = 0; i < bytes.size(); ++i) words_[i / 8] |= static_cast<uint64_t>(bytes[i]) << (8 * (i % 8));
  }

  // Returns 0 to 32 bits from `first` on; bits beyond the block are 0.
  [[nodiscard]] uint32_t get(uint32_t first, uint32_t count) const {
    assert(count <= 32);
    if (first >= 128 || count == 0) return 0;
    const uint64_t low = words_[first / 64] >> (first % 64);
    const uint64_t high = first < 64 && first % 64 != 0 ? words_[1] << (64 - first % 64) : 0;
    return static_cast<uint32_t>((low | high) & ((uint64_t{1} << count) - 1));
  }

  // Reads the next bits, starting with bit 0.
  uint32_t take(uint32_t count) {
    const uint32_t value = get(position_, count);
    position_ += count;
    return value;
  }

 private:
  std::array<uint64_t, 2> words_{};
  uint32_t position_ = 0;
};

// Returns `value` within 0 to `max`.
[[nodiscard]] constexpr uint32_t clamp_to(int value, int max) {
  return static_cast<uint32_t>(value < 0 ? 0 : value > max ? max : value);
}

} // namespace kindling::image_detail
