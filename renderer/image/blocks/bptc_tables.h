// Partitions and weights that BC6H and BC7 have in common.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace kindling::image_detail {

// A partition of 4 x 4 texels into two or three subsets (Khronos Data Format Specification 1.3,
// tables of chapter 21).
struct BptcPartition {
  uint32_t subsets;               // 2 bits for each texel, the first texel lowest
  std::array<uint8_t, 3> anchors; // the texel of each subset whose index is stored with one bit less

  [[nodiscard]] uint32_t subset(uint32_t texel) const { return subsets >> (2 * texel) & 3U; }
};

// Returns the partition of this index, 0 to 63, into 1, 2 or 3 subsets.
[[nodiscard]] BptcPartition bptc_partition(uint32_t subsets, uint32_t index);

// Returns the weight of the second endpoint, 0 to 64, for an index of 2, 3 or 4 bits.
[[nodiscard]] uint32_t bptc_weight(uint32_t index_bits, uint32_t index);

} // namespace kindling::image_detail
