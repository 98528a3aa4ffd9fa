// ASTC's partitions of a block into subsets, which a hash of their index generates.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace kindling::image_detail {

// The partition of a block into 2 to 4 subsets (Khronos Data Format Specification 1.3, 23.21).
class AstcPartition {
 public:
  // `index` has 10 bits; `small_block`: the block has fewer than 31 texels.
  AstcPartition(uint32_t index, uint32_t subsets, bool small_block);

  // Returns the subset of the texel in this column and row.
  [[nodiscard]] uint32_t subset(uint32_t x, uint32_t y) const;

 private:
  std::array<uint32_t, 8> slopes_{}; // along x and y, of each subset
  uint32_t random_ = 0;
  uint32_t subsets_ = 0;
  uint32_t scale_ = 1; // coordinates of small blocks are doubled
};

} // namespace kindling::image_detail
