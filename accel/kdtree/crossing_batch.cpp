// Crossings of a batch of rays, brought into the order of the rays by counting.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/crossing_batch.h"

#include "accel/crossing_collector.h"

#include <limits>

namespace kindling::accel::kd {

bool CrossingBatch::add(uint32_t ray, const Crossing& crossing) {
  if (counts_[ray] >= kMaxOfRay) {
    counts_[ray] = kAside;
    return false;
  }
  ++counts_[ray];
  added_.push_back({ray, crossing});
  return true;
}

void CrossingBatch::leave_aside(uint32_t ray) { counts_[ray] = kAside; }

void CrossingBatch::sort_by_ray() {
  ends_.resize(counts_.size());
  uint32_t total = 0;
  for (size_t ray = 0; ray < counts_.size(); ++ray) {
    ends_[ray] = total; // its beginning, until its crossings follow
    if (counts_[ray] != kAside) total += counts_[ray];
  }
  by_ray_.resize(total);
  for (const Added& one : added_)
    if (counts_[one.ray] != kAside) by_ray_[ends_[one.ray]++] = one.crossing;
}

void CrossingBatch::take(uint32_t ray, size_t limit, std::vector<Crossing>& of_ray) const {
  CrossingCollector collector(of_ray, limit, std::numeric_limits<float>::max());
  for (uint32_t i = ends_[ray] - counts_[ray]; i < ends_[ray]; ++i)
    if (by_ray_[i].hit.t <= collector.t_far()) collector.add(by_ray_[i]);
  collector.finish();
}

} // namespace kindling::accel::kd
