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

  [[nodiscard]] bool is_full() const { return triangles_.count() == kBlockTriangles; }
  // Returns false if the triangle does not fit.
  bool add(const Geometry& geometry, uint32_t triangle) {
    if (is_full()) return false;
    const uint32_t before = vertices_;
    uint32_t corners = 0;
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t index = geometry.mesh.indices[3 * static_cast<size_t>(triangle) + corner];
      const uint32_t vertex = number_of(geometry, index);
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
    const uint32_t triangle_words = triangles_.word_count(), units = LeafBlock::units_for(vertices_, triangle_words);
    std::array<LeafUnit, kMaxUnits + kBlockVertices / 2> block; // room for whole rows
    uint32_t* words = block[0].words.data();
    words[0] = vertices_ | (more ? units : 0U) << LeafBlock::kNextShift | triangles_.header();
    // Copies of a fixed size; the next row overwrites what is too much.
    for (uint32_t axis = 0; axis < 3; ++axis)
      std::memcpy(words + 1 + axis * vertices_, position_[axis].data(), sizeof(position_[axis]));
    triangles_.write(words + 1 + 3 * vertices_);
    words[1 + 3 * vertices_ + triangle_words] = 0; // the padding, if there is any
    out.insert(out.end(), block.begin(), block.begin() + units);
    vertices_ = 0;
    triangles_.clear();
    place_.fill(kFree);
  }

 private:
  static constexpr uint32_t kMaxUnits =
      LeafBlock::units_for(kBlockVertices, BlockTriangles::words_for(kBlockTriangles, 32));
  static constexpr uint32_t kSlots = 64; // size of the hash table with linear probing
  static constexpr uint8_t kFree = 0xff;

  // Returns the number of a vertex, added if new; kBlockVertices if the block is full. Most are
  // found by their index; entries of the table may be out of date, and are compared.
  uint32_t number_of(const Geometry& geometry, uint32_t index) {
    const uint64_t key = uint64_t{geometry.first_primitive} << 32 | index;
    uint8_t& quick = by_index_[(index * 0x9e3779b1U) >> 26];
    if (quick < vertices_ && key_[quick] == key) return quick;
    const uint32_t number = number_of(geometry.mesh.positions[index]);
    if (number == kBlockVertices) return number;
    quick = static_cast<uint8_t>(number);
    key_[number] = key;
    return number;
  }
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
  std::array<uint64_t, kBlockVertices> key_;   // mesh and index by which a vertex was last met
  std::array<uint8_t, 64> by_index_{};         // hash table of vertex numbers by their index
  std::array<uint8_t, kSlots> place_;          // hash table of vertex indices
  std::array<uint8_t, kBlockVertices> slot_{}; // hash table slot of each vertex
  uint32_t vertices_ = 0;
};

// Appends the blocks of some references of a leaf; `more`: others follow.
void append_blocks(std::span<const Geometry> geometries, std::span<const LeafReference> references, bool more,
                   std::vector<LeafUnit>& out) {
  BlockBuilder block;
  // Triangles that do not fit wait for the next block: later ones may still share the present
  // vertices.
  std::array<LeafReference, 64> few;
  std::vector<LeafReference> many(references.size() > few.size() ? references.size() : 0);
  LeafReference* const waiting = many.empty() ? few.data() : many.data();
  while (true) {
    size_t count = 0, next = 0;
    for (; next < references.size() && !block.is_full(); ++next) {
      const LeafReference& r = references[next];
      if (!block.add(geometries[r.geometry], r.triangle)) waiting[count++] = r;
    }
    // The array may be that which is read, in which nothing is overtaken.
    std::copy(references.begin() + static_cast<std::ptrdiff_t>(next), references.end(), waiting + count);
    count += references.size() - next;
    if (count == 0) break;
    block.finish(true, out);
    references = {waiting, count};
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
