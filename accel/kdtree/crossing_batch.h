// Collects the crossings of many rays that are traced together.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// Takes the crossings of rays in any order, the same one several times. A ray with more than
// kMaxOfRay, and one that is left aside, is traced by a query of its own, so that the memory for a
// batch has a bound.
class CrossingBatch {
 public:
  static constexpr uint32_t kMaxOfRay = 64;

  explicit CrossingBatch(size_t ray_count) : counts_(ray_count) {}

  // Returns false if the ray is left aside, or is now. Throws std::bad_alloc. Not inline, because
  // the kernels call it.
  bool add(uint32_t ray, const Crossing& crossing);
  void leave_aside(uint32_t ray);

  // Appends the crossings of each ray to `crossings`, as all_hits() of the ray has them, and sets
  // counts[i] to their number. `single(ray, list)` sets the list of a ray that was left aside.
  template <class Single>
  void finish(size_t limit, const Single& single, std::vector<Crossing>& crossings, std::span<uint32_t> counts) {
    sort_by_ray();
    std::vector<Crossing> of_ray;
    for (uint32_t ray = 0; ray < counts_.size(); ++ray) {
      counts[ray] = 0;
      if (counts_[ray] == 0) continue;
      if (counts_[ray] == kAside)
        single(ray, of_ray);
      else
        take(ray, limit, of_ray);
      crossings.insert(crossings.end(), of_ray.begin(), of_ray.end());
      counts[ray] = static_cast<uint32_t>(of_ray.size());
    }
  }

 private:
  static constexpr uint32_t kAside = kMaxOfRay + 1;
  struct Added {
    uint32_t ray;
    Crossing crossing;
  };

  void sort_by_ray();
  void take(uint32_t ray, size_t limit, std::vector<Crossing>& of_ray) const;

  std::vector<Added> added_;
  std::vector<uint32_t> counts_; // of each ray; kAside: left aside
  std::vector<Crossing> by_ray_; // after sort_by_ray()
  std::vector<uint32_t> ends_;   // of each ray in by_ray_
};

} // namespace kindling::accel::kd
