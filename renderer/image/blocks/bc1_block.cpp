// Decoders of BC1 to BC5.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/blocks/bc1_block.h"

namespace kindling::image_detail {

namespace {

// Returns (of_a a + of_b b) / (of_a + of_b) of two colors of 5, 6 and 5 bits, blue lowest.
Texel blend(uint32_t a, uint32_t b, uint32_t of_a, uint32_t of_b) {
  constexpr std::array<uint32_t, 3> kFirstBit = {11, 5, 0}, kMax = {31, 63, 31};
  Texel result{0, 0, 0, 255};
  for (size_t c = 0; c < 3; ++c) {
    const uint32_t sum = of_a * (a >> kFirstBit[c] & kMax[c]) + of_b * (b >> kFirstBit[c] & kMax[c]);
    const uint32_t unit = (of_a + of_b) * kMax[c];
    result[c] = (2 * 255 * sum + unit) / (2 * unit);
  }
  return result;
}

// Decodes the 8 bytes of color. BC2 and BC3 always have four colors.
void decode_colors(BlockBytes block, bool always_four, bool cutout, TexelBlock& texels) {
  BitField bits(block);
  const uint32_t first = bits.take(16), second = bits.take(16);
  std::array<Texel, 4> colors = {blend(first, second, 1, 0), blend(first, second, 0, 1)};
  if (always_four || first > second) {
    colors[2] = blend(first, second, 2, 1);
    colors[3] = blend(first, second, 1, 2);
  } else {
    colors[2] = blend(first, second, 1, 1);
    colors[3] = {0, 0, 0, cutout ? 0U : 255U};
  }
  for (size_t i = 0; i < 16; ++i) texels[i] = colors[bits.take(2)];
}

// Decodes 8 bytes of one channel: fractions of 255 become fractions of `max`.
void decode_channel(BlockBytes block, size_t channel, uint32_t max, TexelBlock& texels) {
  BitField bits(block);
  const uint32_t first = bits.take(8), second = bits.take(8);
  const uint32_t steps = first > second ? 7 : 5; // between the endpoints
  for (size_t i = 0; i < 16; ++i) {
    const uint32_t index = bits.take(3);
    uint32_t sum = 0; // in units of 1 / (255 steps)
    if (index < 2) {
      sum = (index == 0 ? first : second) * steps;
    } else if (index <= steps) {
      sum = first * (steps + 1 - index) + second * (index - 1);
    } else {
      sum = index == 6 ? 0 : 255 * steps;
    }
    const uint32_t unit = 255 * steps;
    texels[i][channel] = (2 * sum * max + unit) / (2 * unit);
  }
}

} // namespace

void decode_bc1(BlockBytes block, bool cutout, TexelBlock& texels) { decode_colors(block, false, cutout, texels); }

void decode_bc2(BlockBytes block, TexelBlock& texels) {
  decode_colors(block.subspan(8), true, false, texels);
  BitField bits(block.first(8));
  for (size_t i = 0; i < 16; ++i) texels[i][3] = bits.take(4) * 17;
}

void decode_bc3(BlockBytes block, TexelBlock& texels) {
  decode_colors(block.subspan(8), true, false, texels);
  decode_channel(block.first(8), 3, 255, texels);
}

void decode_bc4(BlockBytes block, TexelBlock& texels) {
  for (size_t i = 0; i < 16; ++i) texels[i] = {0, 0, 0, 65535};
  decode_channel(block, 0, 65535, texels);
}

void decode_bc5(BlockBytes block, TexelBlock& texels) {
  decode_bc4(block.first(8), texels);
  decode_channel(block.subspan(8), 1, 65535, texels);
}

} // namespace kindling::image_detail
