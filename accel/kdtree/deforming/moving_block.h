// Leaf blocks of deforming triangles: vertex positions at all keys that a time slice needs.
// The layout extends leaf_block.h. A block in 32-bit words:
//   1             header as that of a LeafBlock
//   1             keys: bits 0-7 intervals between all keys of the mesh, 8-15 the first key stored,
//                 16-23 the number of keys stored (2 or more)
//   3 v k         for each of the k keys x, y and z of the v vertices, one row per axis
//   (n+1)/2, n    corners and primitive indices, as in a LeafBlock
// followed by padding to a multiple of LeafUnit. All triangles of a block belong to meshes with the
// same number of keys.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/deforming/swept.h"
#include "accel/kdtree/leaf_block.h"
#include "accel/motion.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// A view of a block in memory.
class MovingBlock {
 public:
  explicit MovingBlock(const LeafUnit* unit) : words_(unit->words.data()) {}

  [[nodiscard]] uint32_t vertex_count() const { return words_[0] & 31U; }
  [[nodiscard]] uint32_t triangle_count() const { return (words_[0] >> 5) & 31U; }
  [[nodiscard]] bool is_last() const { return (words_[0] & LeafBlock::kMore) == 0; }
  [[nodiscard]] uint32_t filtered() const { return words_[0] >> 16; }
  [[nodiscard]] uint32_t key_count() const { return (words_[1] >> 16) & 255U; }

  // Returns the key interval of a time in the slice, with the arithmetic of key_interval() for the
  // whole mesh; `first` counts from the block's first key.
  [[nodiscard]] KeyInterval interval_at(float time) const {
    const uint32_t segments = words_[1] & 255U, first = (words_[1] >> 8) & 255U;
    KeyInterval at = key_interval(time, segments);
    assert(at.first >= first);
    at.first = std::min(at.first - first, key_count() - 2);
    return at;
  }
  // Returns vertex_count() coordinates at a key of the block.
  [[nodiscard]] const float* row(uint32_t key, uint32_t axis) const {
    assert(key < key_count() && axis < 3);
    return reinterpret_cast<const float*>(words_ + 2 + (3 * key + axis) * vertex_count());
  }
  // Returns the position of a vertex between two keys, with the arithmetic of PositionsAt.
  [[nodiscard]] Imath::V3f vertex(uint32_t number, const KeyInterval& at) const {
    const auto coordinate = [&](uint32_t axis) {
      return between(row(at.first, axis)[number], row(at.first + 1, axis)[number], at.fraction);
    };
    return {coordinate(0), coordinate(1), coordinate(2)};
  }
  // Returns the largest range of a triangle's coordinates along an axis, at any key.
  [[nodiscard]] float largest_extent() const;
  [[nodiscard]] const uint16_t* corners() const {
    return reinterpret_cast<const uint16_t*>(words_ + 2 + 3 * key_count() * vertex_count());
  }
  [[nodiscard]] uint32_t primitive(uint32_t triangle) const {
    assert(triangle < triangle_count());
    return words_[2 + 3 * key_count() * vertex_count() + (triangle_count() + 1) / 2 + triangle];
  }
  [[nodiscard]] uint32_t unit_count() const { return units_for(vertex_count(), triangle_count(), key_count()); }

  static constexpr uint32_t units_for(uint32_t vertices, uint32_t triangles, uint32_t keys) {
    return (2 + 3 * keys * vertices + (triangles + 1) / 2 + triangles + 3) / 4;
  }

 private:
  const uint32_t* words_;
};

// Appends the blocks of a leaf, which must have at least one reference.
void append_moving_leaf(std::span<const Geometry> geometries, std::span<const LeafReference> references,
                        const TimeSlice& slice, std::vector<LeafUnit>& out);

} // namespace kindling::accel::kd
