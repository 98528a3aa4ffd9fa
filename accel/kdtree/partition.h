// Deals the references of a node out to its two children, clipping those that lie in both.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/reference.h"
#include "accel/kdtree/split.h"

#include <cstring>
#include <memory>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// As bytes: Imath's vectors would be copied by component.
inline void copy_references(const Reference* from, size_t count, Reference* to) {
  if (count == 0) return; // pointers may be null
  std::memmove(static_cast<void*>(to), static_cast<const void*>(from), count * sizeof(Reference));
}

// A growing array of references that are not initialized. Growing moves what is there.
class ReferenceBuffer {
 public:
  ReferenceBuffer() = default;
  explicit ReferenceBuffer(size_t size) : items_(std::make_unique_for_overwrite<Reference[]>(size)), capacity_(size) {}

  [[nodiscard]] Reference* data() { return items_.get(); }
  [[nodiscard]] size_t capacity() const { return capacity_; }
  void reserve(size_t size, size_t keep);

 private:
  std::unique_ptr<Reference[]> items_;
  size_t capacity_ = 0;
};

struct HalfCounts {
  size_t left = 0, right = 0;
};

// Serial. One child's references take the place of the node's, which need `count` places; the other child's go to `elsewhere`,
// which must have room for `count`. References that are cut come last in each child; otherwise their order is kept.
[[nodiscard]] HalfCounts partition_in_place(std::span<const Geometry> geometries, Reference* references, size_t count,
                                            const Split& split, bool left_in_place, Reference* elsewhere,
                                            ReferenceBuffer& scratch);

struct Halves {
  ReferenceBuffer left, right;
  HalfCounts counts;
};

// Parallel for many references. Each chunk of fixed size is ordered as above, so that the result does not depend on the number
// of threads.
[[nodiscard]] Halves partition_in_chunks(std::span<const Geometry> geometries, std::span<const Reference> references,
                                         const Split& split);

} // namespace kindling::accel::kd
