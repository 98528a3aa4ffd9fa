// The memory layout of leaf blocks, static and deforming, as queries read it.
//
// A block of a static tree, LeafBlock, in 32-bit words:
//   1             header: bits 0-4 vertices, 5-9 triangles (1 to 16 each), 10-15: distance to the
//                 leaf's next block in LeafUnits, 0 in its last block, bit 16+i: the mesh of
//                 triangle i is not opaque, so the hit filter decides
//   3 v           x, y and z of the v vertices, one row per axis
//   ...           the triangles, see BlockTriangles
// followed by padding to a multiple of LeafUnit. Vertices are compared by bits, so positions that
// differ in the sign of zero are distinct.
//
// A block of a deforming tree, MovingBlock, has vertex positions at all keys that its time slice
// needs:
//   1             header as that of a LeafBlock, but bits 10-15 are 1 if a further block follows
//   1             keys: bits 0-7 intervals between all keys of the mesh, 8-15 the first key stored,
//                 16-23 the number of keys stored (2 or more)
//   3 v k         for each of the k keys x, y and z of the v vertices, one row per axis
//   ...           the triangles, see BlockTriangles
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
struct alignas(8) LeafUnit {
  std::array<uint32_t, 2> words;
};
// Number of units after the last block that wide loads may read; their values are never used.
inline constexpr size_t kLeafPadding = 32;
inline constexpr size_t kUnitsPerLine = 64 / sizeof(LeafUnit); // of the cache

// A view of the n triangles of a block, in 32-bit words:
//   (n+1)/2       corners, 16 bits for each triangle: three 4-bit vertex indices from the lowest
//                 up, then four bits of the primitive indices
//   1             primitive index of the first triangle
//   ...           fields of w bits, from the lowest up, for the other n-1 triangles
// Primitives of a leaf are neighbors, so a block stores their differences to the first one: the
// field has the lower w bits, the four bits beside the corners the bits above. Those four bits of
// the first triangle are w / 4 instead, where w is 0, 4, 8, 16 or 32. If w is 32, the field is the
// whole difference, modulo 2^32.
class BlockTriangles {
 public:
  BlockTriangles(const uint32_t* words, uint32_t count) : words_(words), count_(count) {}

  // Bits 0 to 11 are those of the corners.
  [[nodiscard]] const uint16_t* corners() const { return reinterpret_cast<const uint16_t*>(words_); }
  // Without branches, since hits of the first triangle cannot be predicted.
  [[nodiscard]] uint32_t primitive(uint32_t triangle) const {
    assert(triangle < count_);
    const uint32_t* first = words_ + (count_ + 1) / 2;
    const uint32_t is_other = triangle != 0 ? 1 : 0, width = field_width(), at = (triangle - is_other) * width;
    const uint32_t field = (first[1 + at / 32] >> (at % 32)) & static_cast<uint32_t>((uint64_t{1} << width) - 1);
    const uint32_t upper = static_cast<uint32_t>(corners()[triangle] >> 12) << (width % 32); // 0 if the width is 32
    return first[0] + ((field + upper) & (0U - is_other));
  }
  [[nodiscard]] uint32_t word_count() const { return words_for(count_, field_width()); }

  static constexpr uint32_t words_for(uint32_t triangles, uint32_t width) {
    return (triangles + 1) / 2 + 1 + ((triangles - 1) * width + 31) / 32;
  }

 private:
  [[nodiscard]] uint32_t field_width() const { return static_cast<uint32_t>(corners()[0] >> 12) * 4; }

  const uint32_t* words_;
  uint32_t count_;
};

// A view of a block of a static tree.
class LeafBlock {
 public:
  explicit LeafBlock(const LeafUnit* unit) : words_(unit->words.data()) {}

  [[nodiscard]] uint32_t vertex_count() const { return words_[0] & 31U; }
  [[nodiscard]] uint32_t triangle_count() const { return (words_[0] >> 5) & 31U; }
  [[nodiscard]] bool is_last() const { return units_to_next() == 0; }
  // Returns the distance to the next block of the leaf, or 0 if this is the last one.
  [[nodiscard]] uint32_t units_to_next() const { return (words_[0] >> kNextShift) & kNextMask; }
  // Bit i is set if the hit filter decides about triangle i.
  [[nodiscard]] uint32_t filtered() const { return words_[0] >> 16; }
  // Returns vertex_count() coordinates.
  [[nodiscard]] const float* row(uint32_t axis) const {
    assert(axis < 3);
    return reinterpret_cast<const float*>(words_ + 1 + axis * vertex_count());
  }
  [[nodiscard]] const uint16_t* corners() const { return triangles().corners(); }
  [[nodiscard]] uint32_t primitive(uint32_t triangle) const { return triangles().primitive(triangle); }
  // Returns the size of the block, whether others follow or not.
  [[nodiscard]] uint32_t unit_count() const { return units_for(vertex_count(), triangles().word_count()); }

  static constexpr uint32_t units_for(uint32_t vertices, uint32_t triangle_words) {
    return (1 + 3 * vertices + triangle_words + 1) / 2;
  }
  static constexpr uint32_t kNextShift = 10, kNextMask = 63; // of the header

 private:
  [[nodiscard]] BlockTriangles triangles() const { return {words_ + 1 + 3 * vertex_count(), triangle_count()}; }

  const uint32_t* words_;
};
static_assert(LeafBlock::units_for(kBlockVertices, BlockTriangles::words_for(kBlockTriangles, 32)) <=
              LeafBlock::kNextMask);
static_assert(sizeof(LeafUnit) == 2 * sizeof(uint32_t));

// A view of a block of a deforming tree.
class MovingBlock {
 public:
  explicit MovingBlock(const LeafUnit* unit) : words_(unit->words.data()) {}

  [[nodiscard]] uint32_t vertex_count() const { return words_[0] & 31U; }
  [[nodiscard]] uint32_t triangle_count() const { return (words_[0] >> 5) & 31U; }
  [[nodiscard]] bool is_last() const { return ((words_[0] >> LeafBlock::kNextShift) & LeafBlock::kNextMask) == 0; }
  [[nodiscard]] uint32_t units_to_next() const { return is_last() ? 0 : unit_count(); }
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
  [[nodiscard]] const uint16_t* corners() const { return triangles().corners(); }
  [[nodiscard]] uint32_t primitive(uint32_t triangle) const { return triangles().primitive(triangle); }
  [[nodiscard]] uint32_t unit_count() const { return units_for(vertex_count(), triangles().word_count(), key_count()); }

  static constexpr uint32_t units_for(uint32_t vertices, uint32_t triangle_words, uint32_t keys) {
    return (2 + 3 * keys * vertices + triangle_words + 1) / 2;
  }

 private:
  [[nodiscard]] BlockTriangles triangles() const {
    return {words_ + 2 + 3 * key_count() * vertex_count(), triangle_count()};
  }

  const uint32_t* words_;
};

} // namespace kindling::accel::kd
