// Collects the crossings of one ray: sorted, each once, the nearest of them if there is a limit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/tree_hit.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace kindling::accel {

// Takes crossings in any order, the same one several times. Elements go to a vector of the caller,
// which is sorted now and then, so that a limit keeps it short.
class CrossingCollector {
 public:
  // Clears `crossings`, which has its final content after finish().
  CrossingCollector(std::vector<Crossing>& crossings, size_t limit, float t_max)
      : crossings_(crossings), limit_(limit), full_(limit < kNoLimit / 4 ? limit + limit / 2 + 8 : kNoLimit),
        t_far_(t_max) {
    crossings.clear();
  }

  // Crossings beyond this distance need not be added; it shrinks once the limit is reached.
  [[nodiscard]] float t_far() const { return t_far_; }

  void add(const Crossing& crossing) {
    crossings_.push_back(crossing);
    if (crossings_.size() >= full_) finish();
  }

  void finish() {
    std::sort(crossings_.begin(), crossings_.end(), [](const Crossing& a, const Crossing& b) {
      return a.hit.t != b.hit.t ? a.hit.t < b.hit.t : kd::comes_before(a.hit, b.hit);
    });
    crossings_.erase(std::unique(crossings_.begin(), crossings_.end()), crossings_.end());
    if (crossings_.size() < limit_ || limit_ == 0) return crossings_.resize(std::min(crossings_.size(), limit_));
    crossings_.resize(limit_);
    t_far_ = crossings_.back().hit.t;
  }

 private:
  std::vector<Crossing>& crossings_;
  size_t limit_, full_;
  float t_far_;
};

} // namespace kindling::accel
