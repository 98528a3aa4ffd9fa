// Encodes the triangles of a leaf as blocks with shared vertices.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/leaf_block.h"

#include "accel/kdtree/triangle_packer.h"
#include "accel/vectors.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>

namespace kindling::accel::kd {
namespace {

// 16 numbers, written and compared as vectors: a vector that is loaded where a single number was
// stored would wait for it.
struct Sixteen {
  Int8 low{}, high{};

  // Returns a bit for each number that equals x.
  [[nodiscard]] uint32_t equal(uint32_t x) const {
    const Int8 wanted = Int8{} + static_cast<int32_t>(x);
    return sign_bits(low == wanted) | sign_bits(high == wanted) << 8;
  }
  void set(uint32_t number, uint32_t x) {
    constexpr Int8 kLanes = {0, 1, 2, 3, 4, 5, 6, 7};
    const Int8 at = Int8{} + static_cast<int32_t>(number), value = Int8{} + static_cast<int32_t>(x);
    low = kLanes == at ? value : low;
    high = kLanes + 8 == at ? value : high;
  }
};
static_assert(sizeof(Sixteen) == kBlockVertices * sizeof(uint32_t));

// Collects triangles until the block is full.
class BlockBuilder {
 public:
  [[nodiscard]] bool is_full() const { return triangles_.count() == kBlockTriangles; }
  // Returns false if the triangle does not fit.
  bool add(const Geometry& geometry, uint32_t triangle) {
    if (is_full()) return false;
    const uint32_t before = vertices_;
    if (geometry.first_primitive != geometry_) {
      geometry_ = geometry.first_primitive;
      known_ = 0;
    }
    uint32_t corners = 0;
    for (uint32_t corner = 0; corner < 3; ++corner) {
      const uint32_t index = geometry.mesh.indices[3 * static_cast<size_t>(triangle) + corner];
      const uint32_t vertex = number_of(geometry, index);
      if (vertex == kBlockVertices) {
        vertices_ = before;
        known_ &= (1U << before) - 1;
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
      std::memcpy(words + 1 + axis * vertices_, &position_[axis], sizeof(Sixteen));
    triangles_.write(words + 1 + 3 * vertices_);
    words[1 + 3 * vertices_ + triangle_words] = 0; // the padding, if there is any
    out.insert(out.end(), block.begin(), block.begin() + units);
    vertices_ = 0;
    known_ = 0;
    triangles_.clear();
  }

 private:
  static constexpr uint32_t kMaxUnits =
      LeafBlock::units_for(kBlockVertices, BlockTriangles::words_for(kBlockTriangles, 32));

  // Returns the number of a vertex, added if new; kBlockVertices if the block is full. Most are
  // found by their index, which loads no position.
  uint32_t number_of(const Geometry& geometry, uint32_t index) {
    if (const uint32_t found = index_.equal(index) & known_; found != 0)
      return static_cast<uint32_t>(std::countr_zero(found));
    uint32_t bits[3];
    std::memcpy(bits, &geometry.mesh.positions[index], sizeof(bits));
    // Most are new, and already differ along the first axis.
    uint32_t same = position_[0].equal(bits[0]) & ((1U << vertices_) - 1);
    if (same != 0) same &= position_[1].equal(bits[1]) & position_[2].equal(bits[2]);
    uint32_t number = vertices_;
    if (same != 0) {
      number = static_cast<uint32_t>(std::countr_zero(same));
    } else {
      if (number == kBlockVertices) return number;
      for (uint32_t axis = 0; axis < 3; ++axis) position_[axis].set(number, bits[axis]);
      ++vertices_;
    }
    index_.set(number, index);
    known_ |= 1U << number;
    return number;
  }

  std::array<Sixteen, 3> position_; // by axis, as bit patterns
  TrianglePacker triangles_;
  Sixteen index_;         // by which a vertex was last met
  uint32_t known_ = 0;    // bits of the vertices with an index of the present mesh
  uint32_t geometry_ = 0; // the present mesh, by its first primitive
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
