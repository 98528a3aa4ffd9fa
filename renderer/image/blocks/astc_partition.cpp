// ASTC's partition function.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/blocks/astc_partition.h"

namespace kindling::image_detail {

namespace {

uint32_t hash52(uint32_t p) {
  p ^= p >> 15;
  p -= p << 17;
  p += p << 7;
  p += p << 4;
  p ^= p >> 5;
  p += p << 16;
  p ^= p >> 7;
  p ^= p >> 3;
  p ^= p << 6;
  p ^= p >> 17;
  return p;
}

} // namespace

AstcPartition::AstcPartition(uint32_t index, uint32_t subsets, bool small_block)
    : subsets_(subsets), scale_(small_block ? 2 : 1) {
  const uint32_t seed = index + (subsets - 1) * 1024;
  random_ = hash52(seed);
  const uint32_t of_count = subsets == 3 ? 6 : 5, of_seed = (seed & 2U) != 0 ? 4 : 5;
  const bool swapped = (seed & 1U) != 0;
  const uint32_t shift_x = swapped ? of_seed : of_count, shift_y = swapped ? of_count : of_seed;
  for (uint32_t i = 0; i < slopes_.size(); ++i) {
    const uint32_t bits = random_ >> (4 * i) & 15U;
    slopes_[i] = bits * bits >> (i % 2 == 0 ? shift_x : shift_y);
  }
}

uint32_t AstcPartition::subset(uint32_t x, uint32_t y) const {
  uint32_t best = 0, highest = 0;
  for (uint32_t s = 0; s < subsets_; ++s) {
    const uint32_t height = (scale_ * (slopes_[2 * s] * x + slopes_[2 * s + 1] * y) + (random_ >> (14 - 4 * s))) & 63U;
    if (s > 0 && height <= highest) continue;
    best = s;
    highest = height;
  }
  return best;
}

} // namespace kindling::image_detail
