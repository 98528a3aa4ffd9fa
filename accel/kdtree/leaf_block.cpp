// Encodes the triangles of a leaf as blocks with shared vertices.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/leaf_block.h"

#include "accel/kdtree/triangle_packer.h"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace kindling::accel::kd {
namespace {

// Collects triangles until the block is full.
class BlockBuilder {
 public:
  BlockBuilder() { place_.fill(kFree); }

  // Returns false if the triangle does not fit.
  bool add(const Geometry& geometry, uint32_t triangle) {
    if (triangles_.count() == kBlockTriangles) return false;
    const uint32_t before = vertices_;
    uint32_t corners = 0;
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = number_of(geometry.vertex(triangle, static_cast<int>(corner)));
      if (vertex == kBlockVertices) {
        while (vertices_ > before)
          place_[slot_[--vertices_]] = kFree; // in reverse order, to keep probe sequences intact
        return false;
      }
      corners |= vertex << (4 * corner);
    }
    triangles_.add(corners, geometry.first_primitive + triangle, geometry.mesh.opaque);
    return true;
  }

  // Appends the block to `out` and starts the next.
  void finish(bool more, std::vector<LeafUnit>& out) {
    const size_t first = out.size();
    const uint32_t units = LeafBlock::units_for(vertices_, triangles_.word_count());
    out.resize(first + units, LeafUnit{});
    uint32_t* words = out[first].words.data();
    words[0] = vertices_ | (more ? units : 0U) << LeafBlock::kNextShift | triangles_.header();
    for (uint32_t axis = 0; axis < 3; ++axis)
      std::memcpy(words + 1 + axis * vertices_, position_[axis].data(), vertices_ * sizeof(uint32_t));
    triangles_.write(words + 1 + 3 * vertices_);
    vertices_ = 0;
    triangles_.clear();
    place_.fill(kFree);
  }

 private:
  static constexpr uint32_t kSlots = 64; // size of the hash table with linear probing
  static constexpr uint8_t kFree = 0xff;

  // Returns the index of a vertex, added if new; kBlockVertices if the block is full.
  uint32_t number_of(const Imath::V3f& p) {
    uint32_t bits[3];
    std::memcpy(bits, &p, sizeof(bits));
    uint32_t slot = ((bits[0] ^ (bits[1] * 0x85ebca6bU) ^ (bits[2] * 0xc2b2ae35U)) * 0x9e3779b1U) >> 26;
    for (; place_[slot] != kFree; slot = (slot + 1) % kSlots) {
      const uint32_t i = place_[slot];
      if (position_[0][i] == bits[0] && position_[1][i] == bits[1] && position_[2][i] == bits[2]) return i;
    }
    if (vertices_ == kBlockVertices) return kBlockVertices;
    for (uint32_t axis = 0; axis < 3; ++axis) position_[axis][vertices_] = bits[axis];
    place_[slot] = static_cast<uint8_t>(vertices_);
    slot_[vertices_] = static_cast<uint8_t>(slot);
    return vertices_++;
  }

  std::array<std::array<uint32_t, kBlockVertices>, 3> position_; // by axis, as bit patterns
  TrianglePacker triangles_;
  std::array<uint8_t, kSlots> place_;          // hash table of vertex indices
  std::array<uint8_t, kBlockVertices> slot_{}; // hash table slot of each vertex
  uint32_t vertices_ = 0;
};

// Appends the blocks of some references of a leaf; `more`: others follow.
void append_blocks(std::span<const Geometry> geometries, std::span<const LeafReference> references, bool more,
                   std::vector<LeafUnit>& out) {
  BlockBuilder block;
  const auto add = [&](const LeafReference& r) { return block.add(geometries[r.geometry], r.triangle); };
  // Triangles that do not fit wait for the next block: later ones may still share the present
  // vertices.
  std::array<LeafReference, 64> few;
  std::vector<LeafReference> many(references.size() > few.size() ? references.size() : 0);
  LeafReference* const waiting = many.empty() ? few.data() : many.data();
  size_t count = 0;
  for (const LeafReference& reference : references)
    if (!add(reference)) waiting[count++] = reference;
  while (count > 0) {
    block.finish(true, out);
    count = static_cast<size_t>(std::remove_if(waiting, waiting + count, add) - waiting);
  }
  block.finish(more, out);
}

} // namespace

void append_leaf(std::span<const Geometry> geometries, std::span<const LeafReference> references,
                 std::vector<LeafUnit>& out) {
  assert(!references.empty());
  for_each_leaf_part(
      references, [&](std::span<const LeafReference> part, bool more) { append_blocks(geometries, part, more, out); });
}

} // namespace kindling::accel::kd
