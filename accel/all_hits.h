// Every crossing of many rays, by all threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

namespace kindling::accel {

// The crossings of several rays, one ray after the other.
struct CrossingLists {
  std::vector<size_t> first; // one more than there are rays: ray i has [first[i], first[i + 1])
  std::vector<Crossing> crossings;

  [[nodiscard]] size_t ray_count() const { return first.empty() ? 0 : first.size() - 1; }
  [[nodiscard]] std::span<const Crossing> of(size_t ray) const {
    assert(ray < ray_count());
    return std::span(crossings).subspan(first[ray], first[ray + 1] - first[ray]);
  }
};

// Sets `lists` to what Accelerator::all_hits() returns for each ray. Parallel with TBB in the
// caller's arena; the result does not depend on the number of threads. Returns false if the
// accelerator cannot answer. Throws std::bad_alloc.
[[nodiscard]] bool all_hits(const Accelerator& accelerator, std::span<const Ray> rays, size_t limit,
                            CrossingLists& lists);

} // namespace kindling::accel
