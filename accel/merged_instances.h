// Chooses the instances under identity transforms whose triangles join the world's structure.
//
// Their rays need no second level. But triangles that several instances place at the same spot
// multiply the structure: from a budget on, such copies are traced as instances like all others.
// The answers are the same; of coincident hits the smallest ids count.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling::accel {

class MergedInstances {
 public:
  // Maximum number of triangles that are stored more than once.
  static constexpr uint64_t kMaxCopiedTriangles = 1U << 18;

  explicit MergedInstances(size_t groups) : placed_(groups, 0) {}

  // To be called for each static instance under an identity transform, in order. Returns whether
  // the triangles of its group join the world's structure; the first copy of each group does.
  [[nodiscard]] bool take(uint32_t group, uint64_t triangles) {
    if (placed_[group] == 0) {
      placed_[group] = 1;
      return true;
    }
    if (triangles > kMaxCopiedTriangles - copied_) return false;
    copied_ += triangles;
    return true;
  }

 private:
  std::vector<uint8_t> placed_; // by group
  uint64_t copied_ = 0;
};

} // namespace kindling::accel
