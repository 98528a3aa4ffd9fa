// The references of a node, as the split searches read them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/occupied_space.h"
#include "accel/kdtree/build/reference.h"
#include "accel/kdtree/build/reference_blocks.h"

#include <span>
#include <vector>

namespace kindling::accel::kd {

// Borrowed references in one run or several, and the box around them.
class NodeReferences {
 public:
  NodeReferences(std::span<const Reference> all) : first_(all), count_(all.size()) { space_.extend(all); }
  NodeReferences(const std::vector<Reference>& all) : NodeReferences(std::span<const Reference>(all)) {}
  NodeReferences(const ReferenceBlocks& references)
      : blocks_(references.blocks()), count_(references.count()), space_(references.space()) {}

  [[nodiscard]] size_t count() const { return count_; }
  [[nodiscard]] const OccupiedSpace& space() const { return space_; }
  [[nodiscard]] size_t run_count() const { return blocks_.empty() ? 1 : blocks_.size(); }
  [[nodiscard]] std::span<const Reference> run(size_t i) const { return blocks_.empty() ? first_ : blocks_[i]; }

 private:
  std::span<const Reference> first_;             // unless there are blocks
  std::span<const std::span<Reference>> blocks_; // none is empty
  size_t count_;
  OccupiedSpace space_;
};

} // namespace kindling::accel::kd
