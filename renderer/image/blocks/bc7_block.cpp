// Decoder of BC7 blocks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/blocks/bc7_block.h"

#include "renderer/image/blocks/bptc_tables.h"

#include <utility>

namespace kindling::image_detail {

namespace {

struct Bc7Mode {
  uint8_t subsets, partition_bits, rotation_bits, selection_bits, color_bits, alpha_bits;
  uint8_t shared_bits; // lowest bits of endpoints: for each of them 2, for each pair 1, none 0
  uint8_t index_bits, second_index_bits;
};

constexpr std::array<Bc7Mode, 8> kBc7Modes = {{{3, 4, 0, 0, 4, 0, 2, 3, 0},
                                               {2, 6, 0, 0, 6, 0, 1, 3, 0},
                                               {3, 6, 0, 0, 5, 0, 0, 2, 0},
                                               {2, 6, 0, 0, 7, 0, 2, 2, 0},
                                               {1, 0, 2, 1, 5, 6, 0, 2, 3},
                                               {1, 0, 2, 0, 7, 8, 0, 2, 2},
                                               {1, 0, 0, 0, 7, 7, 2, 4, 0},
                                               {2, 6, 0, 0, 5, 5, 2, 2, 0}}};

// Reads the endpoints of all subsets, two each, and widens them to 8 bits by replication.
std::array<Texel, 6> read_bc7_endpoints(BitField& bits, const Bc7Mode& mode) {
  std::array<Texel, 6> ends{};
  const size_t count = size_t{2} * mode.subsets;
  for (size_t c = 0; c < 4; ++c) {
    const uint32_t width = c < 3 ? mode.color_bits : mode.alpha_bits;
    for (size_t e = 0; e < count; ++e) ends[e][c] = bits.take(width);
  }
  uint32_t shared = 0;
  for (size_t e = 0; e < count && mode.shared_bits > 0; ++e) {
    if (mode.shared_bits == 2 || e % 2 == 0) shared = bits.take(1);
    for (uint32_t& value : ends[e]) value = value << 1 | shared;
  }
  const uint32_t extra = mode.shared_bits > 0 ? 1 : 0;
  for (size_t e = 0; e < count; ++e) {
    for (size_t c = 0; c < 4; ++c) {
      const uint32_t width = c < 3 ? mode.color_bits : mode.alpha_bits;
      ends[e][c] = width == 0 ? 255 : ends[e][c] << (8 - width - extra) | ends[e][c] >> (2 * (width + extra) - 8);
    }
  }
  return ends;
}

} // namespace

void decode_bc7(BlockBytes block, TexelBlock& texels) {
  BitField bits(block);
  uint32_t number = 0;
  while (number < 8 && bits.take(1) == 0) ++number;
  if (number == 8) {
    for (size_t i = 0; i < 16; ++i) texels[i] = {};
    return;
  }
  const Bc7Mode& mode = kBc7Modes[number];
  const BptcPartition partition = bptc_partition(mode.subsets, bits.take(mode.partition_bits));
  const uint32_t rotation = bits.take(mode.rotation_bits);
  const bool color_is_second = bits.take(mode.selection_bits) != 0;
  const std::array<Texel, 6> ends = read_bc7_endpoints(bits, mode);

  std::array<uint32_t, 16> first{}, second{};
  for (uint32_t i = 0; i < 16; ++i) {
    const bool anchor = partition.anchors[partition.subset(i)] == i;
    first[i] = bptc_weight(mode.index_bits, bits.take(mode.index_bits - (anchor ? 1U : 0U)));
  }
  for (uint32_t i = 0; i < 16 && mode.second_index_bits > 0; ++i) {
    second[i] = bptc_weight(mode.second_index_bits, bits.take(mode.second_index_bits - (i == 0 ? 1U : 0U)));
  }
  for (uint32_t i = 0; i < 16; ++i) {
    const size_t e = size_t{2} * partition.subset(i);
    const uint32_t color = color_is_second ? second[i] : first[i];
    const uint32_t alpha = mode.second_index_bits == 0 || color_is_second ? first[i] : second[i];
    for (size_t c = 0; c < 4; ++c) {
      const uint32_t weight = c < 3 ? color : alpha;
      texels[i][c] = (ends[e][c] * (64 - weight) + ends[e + 1][c] * weight + 32) >> 6;
    }
    if (rotation > 0) std::swap(texels[i][3], texels[i][rotation - 1]);
  }
}

} // namespace kindling::image_detail
