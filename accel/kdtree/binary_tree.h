// The binary kd-tree as built, before it is laid out, and the arenas that own its nodes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/aligned_array.h"

#include <ImathBox.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling::accel::kd {

struct LeafReference {
  uint32_t geometry;
  uint32_t triangle;
};

// An inner node, a leaf, or an empty node (a leaf without triangles).
struct BinaryNode {
  static constexpr uint32_t kLeaf = 3;

  float position = 0.0f; // inner node: position of the plane; of a deforming tree, at the begin of its slice
  uint32_t axis = kLeaf; // inner node: 0 to 2
  uint32_t count = 0;    // leaf: number of references
  // Inner node: the summed area of the finished nodes needed, relative to the area of the whole
  // tree, if the node may take up to 1 to 7 lanes of its parent's (see box_cuts.h). Leaf: 0.
  std::array<float, 7> area_cost{};
  union {
    // Inner node: two children, below and above the plane. In a deforming tree two further nodes
    // follow, which have the bounds of the children at the end of the slice and nothing else.
    BinaryNode* children = nullptr;
    const LeafReference* references; // leaf
  };
  // Bounds of what is near the triangles, within their margins, and in the cell; empty for an empty
  // node. Of a deforming tree, at the begin of its slice.
  Imath::Box3f bounds;

  // The bounds of a child of a deforming tree at the end of its slice.
  [[nodiscard]] Imath::Box3f& bounds_at_end() { return this[2].bounds; }
  [[nodiscard]] bool is_inner() const { return axis != kLeaf; }
  [[nodiscard]] bool is_empty() const { return axis == kLeaf && count == 0; }
};
static_assert(sizeof(BinaryNode) == 72);

// A stack allocator of arrays with stable addresses; the latest allocations can be released again.
// Not thread-safe.
template <class T>
class StackArena {
 public:
  struct Mark {
    size_t chunk = 0, used = 0;
  };

  // Elements are not initialized.
  [[nodiscard]] T* allocate(size_t count) {
    while (at_.chunk < chunks_.size() && chunks_[at_.chunk].capacity - at_.used < count) at_ = {at_.chunk + 1, 0};
    if (at_.chunk == chunks_.size()) {
      const size_t bytes =
          std::max(count * sizeof(T), std::min(kMinBytes << std::min<size_t>(chunks_.size(), 16), kMaxBytes));
      chunks_.push_back({AlignedArray<std::byte>(bytes), bytes / sizeof(T)});
    }
    T* first = reinterpret_cast<T*>(chunks_[at_.chunk].items.data()) + at_.used;
    at_.used += count;
    return first;
  }
  [[nodiscard]] Mark mark() const { return at_; }
  // Releases all allocations made since `mark`.
  void rewind(const Mark& mark) {
    assert(mark.chunk < at_.chunk || (mark.chunk == at_.chunk && mark.used <= at_.used));
    at_ = mark;
  }

 private:
  static constexpr size_t kMinBytes = size_t{4} << 10, kMaxBytes = size_t{2} << 20; // the latter is a huge page
  struct Chunk {
    AlignedArray<std::byte> items;
    size_t capacity;
  };
  std::vector<Chunk> chunks_;
  Mark at_;
};

struct TreeArena {
  StackArena<BinaryNode> nodes;
  StackArena<LeafReference> references;
};

} // namespace kindling::accel::kd
