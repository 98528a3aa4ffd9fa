// Crossings of one ray: sorting, and dropping of those that repeat or lie beyond the limit.
// SPDX-License-Identifier: Apache-2.0
#include "accel/crossing_collector.h"

#include "accel/kdtree/tree_hit.h"

#include <algorithm>

namespace kindling::accel {

CrossingCollector::CrossingCollector(std::vector<Crossing>& crossings, size_t limit, float t_max)
    : crossings_(crossings), limit_(limit), full_(limit < kNoLimit / 4 ? limit + limit / 2 + 8 : kNoLimit),
      t_far_(t_max) {
  crossings.clear();
}

void CrossingCollector::add(const Crossing& crossing) {
  crossings_.push_back(crossing);
  if (crossings_.size() >= full_) finish();
}

void CrossingCollector::finish() {
  if (crossings_.size() > 1) {
    std::sort(crossings_.begin(), crossings_.end(), [](const Crossing& a, const Crossing& b) {
      return a.hit.t != b.hit.t ? a.hit.t < b.hit.t : kd::comes_before(a.hit, b.hit);
    });
    crossings_.erase(std::unique(crossings_.begin(), crossings_.end()), crossings_.end());
  }
  if (crossings_.size() < limit_ || limit_ == 0) return crossings_.resize(std::min(crossings_.size(), limit_));
  crossings_.resize(limit_);
  t_far_ = crossings_.back().hit.t;
}

} // namespace kindling::accel
