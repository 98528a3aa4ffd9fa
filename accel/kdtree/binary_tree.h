// The binary kd-tree between building and laying out, and the arenas that it lives in until the layout is done.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace kindling::accel::kd {

struct LeafReference {
  uint32_t geometry;
  uint32_t triangle;
};

// Inner node, leaf, or empty (a leaf of no triangles).
struct BinaryNode {
  static constexpr uint32_t kLeaf = 3;

  float position = 0.0f; // of an inner node
  uint32_t axis = kLeaf; // of an inner node: 0 to 2
  uint32_t count = 0;    // leaf: references; inner node: the bits of way()
  // Inner node: sum of the areas of the wide nodes needed if it may be cut up to 0, 1 or 2 levels further down, relative to the
  // area of the whole tree; see wide_cuts.h. Leaf: 0.
  std::array<float, 3> cut_cost{};
  union {
    BinaryNode* children = nullptr;  // inner node: two, below and above the plane
    const LeafReference* references; // leaf
  };

  // Of an inner node, how far its plane moves in its slice of the shutter; 0 in trees of what stands still.
  [[nodiscard]] float way() const { return std::bit_cast<float>(count); }
  void set_way(float way) { count = std::bit_cast<uint32_t>(way); }
  [[nodiscard]] bool is_inner() const { return axis != kLeaf; }
  [[nodiscard]] bool is_empty() const { return axis == kLeaf && count == 0; }
};
static_assert(sizeof(BinaryNode) == 32);

// Hands out arrays that stay where they are; what was handed out last can be taken back. One thread at a time.
template <class T>
class StackArena {
 public:
  struct Mark {
    size_t chunk = 0, used = 0;
  };

  // Not initialized.
  [[nodiscard]] T* allocate(size_t count) {
    while (at_.chunk < chunks_.size() && chunks_[at_.chunk].capacity - at_.used < count) at_ = {at_.chunk + 1, 0};
    if (at_.chunk == chunks_.size()) {
      const size_t capacity = std::max(count, kSmallest << std::min<size_t>(chunks_.size(), kDoublings));
      chunks_.push_back({std::make_unique_for_overwrite<T[]>(capacity), capacity});
    }
    T* first = chunks_[at_.chunk].items.get() + at_.used;
    at_.used += count;
    return first;
  }
  [[nodiscard]] Mark mark() const { return at_; }
  // Takes back all that was handed out since.
  void rewind(const Mark& mark) { at_ = mark; }

 private:
  static constexpr size_t kSmallest = 64, kDoublings = 7;
  struct Chunk {
    std::unique_ptr<T[]> items;
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
