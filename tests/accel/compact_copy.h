// The compact queries of a kd-tree, over a copy of its arrays in other memory.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/view.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kindling::accel::testing {

// Copies what the view of a kd-tree refers to, as it would be copied to a GPU, so that a query that
// reads anything else is found.
class CompactCopy {
 public:
  // Throws std::invalid_argument if the accelerator is no kd-tree.
  explicit CompactCopy(const Accelerator& accelerator);

  [[nodiscard]] Hit intersect(const Ray& ray) const;
  [[nodiscard]] bool occluded(const Ray& ray) const;
  [[nodiscard]] const kd::StructureView& view() const { return view_; }
  // Returns true if an address is in the copied arrays.
  [[nodiscard]] bool contains(const void* address) const;

 private:
  struct Block {
    std::unique_ptr<std::byte[]> bytes;
    size_t size = 0;
  };

  // Copies an array and sets the span to the copy.
  template <class T>
  void copy(std::span<const T>& array);

  std::vector<Block> blocks_;
  kd::StructureView view_;
  HitFilter filter_;
};

// Returns an accelerator that answers every query by the compact ones, ray by ray, and passes the
// rest on.
[[nodiscard]] std::unique_ptr<Accelerator> with_compact_queries(std::unique_ptr<Accelerator> kdtree);

} // namespace kindling::accel::testing
