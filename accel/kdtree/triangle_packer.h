// Writes the triangles of a leaf block: the counterpart of BlockTriangles (leaf_format.h).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/leaf_format.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <cstring>

namespace kindling::accel::kd {

// Collects up to kBlockTriangles triangles. Sorted primitives take the least memory; any order is
// stored correctly.
class TrianglePacker {
 public:
  [[nodiscard]] uint32_t count() const { return count_; }

  // `corners`: three 4-bit vertex indices from the lowest up. `opaque`: false if the hit filter
  // decides.
  void add(uint32_t corners, uint32_t primitive, bool opaque) {
    assert(count_ < kBlockTriangles && corners < (1U << 12));
    corners_[count_] = static_cast<uint16_t>(corners);
    primitives_[count_] = primitive;
    filtered_ |= (opaque ? 0U : 1U) << count_;
    largest_ = std::max(largest_, primitive - primitives_[0]);
    ++count_;
  }
  void clear() { count_ = filtered_ = largest_ = 0; }

  // Returns the triangles' bits of a block's header.
  [[nodiscard]] uint32_t header() const { return count_ << 5 | filtered_ << 16; }
  [[nodiscard]] uint32_t word_count() const { return BlockTriangles::words_for(count_, field_width()); }
  // Writes word_count() words. At least one triangle must have been added.
  void write(uint32_t* words) const {
    assert(count_ > 0);
    const uint32_t width = field_width(), corner_words = (count_ + 1) / 2;
    std::array<uint16_t, kBlockTriangles> corners{};
    std::array<uint32_t, kBlockTriangles> fields{};
    corners[0] = static_cast<uint16_t>(corners_[0] | (width / 4) << 12);
    for (uint32_t i = 1; i < count_; ++i) {
      const uint32_t difference = primitives_[i] - primitives_[0];
      const uint32_t upper = width == 32 ? 0 : difference >> width, at = (i - 1) * width;
      corners[i] = static_cast<uint16_t>(corners_[i] | upper << 12);
      const auto lower = static_cast<uint32_t>(difference & ((uint64_t{1} << width) - 1));
      if (width != 0) fields[at / 32] |= lower << (at % 32);
    }
    std::memcpy(words, corners.data(), corner_words * sizeof(uint32_t));
    words[corner_words] = primitives_[0];
    std::memcpy(words + corner_words + 1, fields.data(), (word_count() - corner_words - 1) * sizeof(uint32_t));
  }

 private:
  // Returns the width of the fields: the least one, with the four bits beside the corners.
  [[nodiscard]] uint32_t field_width() const {
    for (const uint32_t width : {0U, 4U, 8U, 16U})
      if ((largest_ >> (width + 4)) == 0) return width;
    return 32;
  }

  std::array<uint16_t, kBlockTriangles> corners_;
  std::array<uint32_t, kBlockTriangles> primitives_;
  uint32_t count_ = 0, filtered_ = 0;
  uint32_t largest_ = 0; // difference to the first primitive
};

} // namespace kindling::accel::kd
