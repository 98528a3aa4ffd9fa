// Leaf blocks: up to 16 triangles with up to 16 shared vertices.
//
// The triangles of a leaf are neighbors: ten of them have about ten vertices, not thirty. Storing
// each vertex once at least halves the memory, and a ray is translated and sheared to each vertex
// once before the triangles select theirs by permutation. The arithmetic for a triangle is the same
// as if its vertices were stored separately.
//
// A block in 32-bit words:
//   1             header: bits 0-4 vertices, 5-9 triangles (1 to 16 each), bit 10: the leaf
//                 continues in a further block, bit 16+i: the mesh of triangle i is not opaque,
//                 so the hit filter decides
//   3 v           x, y and z of the v vertices, one row per axis
//   (n+1)/2       corners, 16 bits for each of the n triangles: three 4-bit vertex indices from
//                 the lowest up
//   n             primitive indices
// followed by padding to a multiple of LeafUnit. Vertices are compared by bits, so positions that
// differ in the sign of zero are distinct.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/reference.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::accel::kd {

inline constexpr uint32_t kBlockTriangles = 16, kBlockVertices = 16;

// The unit of addresses in Tree::leaves.
struct alignas(16) LeafUnit {
  std::array<uint32_t, 4> words;
};
// Number of units after the last block that wide loads may read; their values are never used.
inline constexpr size_t kLeafPadding = 16;

// A view of a block in memory.
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

// Calls append(part, more) for the parts of a leaf that are encoded one after the other; `more` is
// false for the last one. Each block tries all references of its part that are left, so without
// parts the time would grow with the square of the leaf. Ordinary leaves are one part.
inline constexpr size_t kMaxLeafPart = 2048;
template <class Append>
void for_each_leaf_part(std::span<const LeafReference> references, const Append& append) {
  for (; references.size() > kMaxLeafPart; references = references.subspan(kMaxLeafPart))
    append(references.first(kMaxLeafPart), true);
  append(references, false);
}

// Appends the blocks of a leaf, which must have at least one reference.
void append_leaf(std::span<const Geometry> geometries, std::span<const LeafReference> references,
                 std::vector<LeafUnit>& out);

} // namespace kindling::accel::kd
