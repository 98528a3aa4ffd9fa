// Partitions the references of a node to its two children, and clips those on both sides.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/reference.h"
#include "accel/kdtree/build/reference_blocks.h"
#include "accel/kdtree/build/split.h"

#include <cstring>
#include <memory>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// Copies bytes, since Imath's vectors would be copied by component. The ranges may overlap.
inline void copy_references(const Reference* from, size_t count, Reference* to) {
  if (count == 0) return; // pointers may be null
  std::memmove(static_cast<void*>(to), static_cast<const void*>(from), count * sizeof(Reference));
}

// A growing array of uninitialized references. Growing preserves its first elements.
class ReferenceBuffer {
 public:
  [[nodiscard]] Reference* data() { return items_.get(); }
  void reserve(size_t size, size_t keep);

 private:
  std::unique_ptr<Reference[]> items_;
  size_t capacity_ = 0;
};

struct HalfCounts {
  size_t left = 0, right = 0;
};

// Partitions on one thread. One child's references replace those of the node, which need `count`
// places; the other child's go to `elsewhere`, which must have room for `count`. Parts of split
// references come last in each child; the others keep their order.
[[nodiscard]] HalfCounts partition_in_place(const BuildMeshes& meshes, Reference* references, size_t count,
                                            const Split& split, bool left_in_place, Reference* elsewhere,
                                            ReferenceBuffer& scratch);

struct BlockHalves {
  ReferenceBlocks left, right;
};

// Partitions many references in parallel, and returns their blocks to the pool. Each group of
// blocks is ordered as above, so that the result does not depend on the number of threads.
[[nodiscard]] BlockHalves partition(const BuildMeshes& meshes, ReferenceBlocks references, const Split& split,
                                    BlockPool& pool);

} // namespace kindling::accel::kd
