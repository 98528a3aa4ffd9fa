// The memory layout of leaf blocks, static and deforming, as queries read it.
//
// A block of a static tree, LeafBlock, in 32-bit words:
//   1             header: bits 0-4 vertices, 5-9 triangles (1 to 16 each), bit 10: the leaf
//                 continues in a further block, bit 16+i: the mesh of triangle i is not opaque,
//                 so the hit filter decides
//   3 v           x, y and z of the v vertices, one row per axis
//   (n+1)/2       corners, 16 bits for each of the n triangles: three 4-bit vertex indices from
//                 the lowest up
//   n             primitive indices
// followed by padding to a multiple of LeafUnit. Vertices are compared by bits, so positions that
// differ in the sign of zero are distinct.
//
// A block of a deforming tree, MovingBlock, has vertex positions at all keys that its time slice
// needs:
//   1             header as that of a LeafBlock
//   1             keys: bits 0-7 intervals between all keys of the mesh, 8-15 the first key stored,
//                 16-23 the number of keys stored (2 or more)
//   3 v k         for each of the k keys x, y and z of the v vertices, one row per axis
//   (n+1)/2, n    corners and primitive indices, as in a LeafBlock
// followed by padding to a multiple of LeafUnit. All triangles of a block belong to meshes with the
// same number of keys.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/motion_keys.h"

#include <ImathVec.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>

namespace kindling::accel::kd {

inline constexpr uint32_t kBlockTriangles = 16, kBlockVertices = 16;

// The unit of addresses in Tree::leaves.
struct alignas(16) LeafUnit {
  std::array<uint32_t, 4> words;
};
// Number of units after the last block that wide loads may read; their values are never used.
inline constexpr size_t kLeafPadding = 16;

// A view of a block of a static tree.
class LeafBlock {
 public:
  explicit LeafBlock(const LeafUnit* unit) : words_(unit->words.data()) {}

  [[nodiscard]] uint32_t vertex_count() const { return words_[0] & 31U; }
  [[nodiscard]] uint32_t triangle_count() const { return (words_[0] >> 5) & 31U; }
  [[nodiscard]] bool is_last() const { return (words_[0] & kMore) == 0; }
  // Bit i is set if the hit filter decides about triangle i.
  [[nodiscard]] uint32_t filtered() const { return words_[0] >> 16; }
  // Returns vertex_count() coordinates.
  [[nodiscard]] const float* row(uint32_t axis) const {
    assert(axis < 3);
    return reinterpret_cast<const float*>(words_ + 1 + axis * vertex_count());
  }
  [[nodiscard]] const uint16_t* corners() const {
    return reinterpret_cast<const uint16_t*>(words_ + 1 + 3 * vertex_count());
  }
  [[nodiscard]] uint32_t primitive(uint32_t triangle) const {
    assert(triangle < triangle_count());
    return words_[1 + 3 * vertex_count() + (triangle_count() + 1) / 2 + triangle];
  }
  [[nodiscard]] uint32_t unit_count() const { return units_for(vertex_count(), triangle_count()); }

  static constexpr uint32_t units_for(uint32_t vertices, uint32_t triangles) {
    return (1 + 3 * vertices + (triangles + 1) / 2 + triangles + 3) / 4;
  }
  static constexpr uint32_t kMore = 1U << 10;

 private:
  const uint32_t* words_;
};

// A view of a block of a deforming tree.
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

} // namespace kindling::accel::kd
