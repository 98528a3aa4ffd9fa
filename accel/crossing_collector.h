// Collects the crossings of one ray: sorted, each once, the nearest of them if there is a limit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <cstddef>
#include <vector>

namespace kindling::accel {

// Takes crossings in any order, the same one several times. Elements go to a vector of the caller,
// which is sorted now and then, so that a limit keeps it short.
class CrossingCollector {
 public:
  // Clears `crossings`, which has its final content after finish().
  CrossingCollector(std::vector<Crossing>& crossings, size_t limit, float t_max);

  // Crossings beyond this distance need not be added; it shrinks once the limit is reached.
  [[nodiscard]] float t_far() const { return t_far_; }

  // Throws std::bad_alloc. Not inline, because the kernels call it.
  void add(const Crossing& crossing);
  void finish();

 private:
  std::vector<Crossing>& crossings_;
  size_t limit_, full_;
  float t_far_;
};

} // namespace kindling::accel
