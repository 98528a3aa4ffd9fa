// Traces sets of rays by every form of call, and times it; the same code times plugins.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/app/options/shootout_clock.h"
#include "renderer/app/shootout/shootout_report.h"
#include "renderer/base/stopwatch.h"
#include "renderer/session/ray_set.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::app {

// The answers to a set of rays: `hits` for RayQuery::nearest, `occluded` for RayQuery::any_hit.
struct Answers {
  std::vector<accel::Hit> hits;
  std::vector<uint8_t> occluded;

  explicit Answers(const RaySet& set);
  // Returns the memory of those of its query; the others are empty.
  [[nodiscard]] std::span<std::byte> bytes() {
    return hits.empty() ? std::as_writable_bytes(std::span(occluded)) : std::as_writable_bytes(std::span(hits));
  }
};

// Traces all rays of the set. A batch call gets `batch_size` rays, a coherent call one group, or a
// batch if the set has no groups. Embree's own calls are batch calls of the adapters of
// with_embree_call().
void trace(const accel::Accelerator& accelerator, const RaySet& set, CallForm form, uint32_t batch_size,
           Answers& answers);

// Wall and CPU time of `work` by the readings of `clock`. The CPU interval encloses the other one,
// so that short work does not seem to have waited for a processor.
template <typename Work>
WorkTime measure(double (*clock)(ShootoutClock), const Work& work) {
  const double cpu_start = clock(ShootoutClock::cpu), wall_start = clock(ShootoutClock::wall);
  work();
  const double wall_s = clock(ShootoutClock::wall) - wall_start;
  return {wall_s, clock(ShootoutClock::cpu) - cpu_start};
}

// The wall time of a single nearest-hit call for each ray in nanoseconds, minus that of reading the
// clock; the median of kHeatMapRounds rounds over all rays.
inline constexpr int kHeatMapRounds = 7;
[[nodiscard]] std::vector<float> time_single_calls(const accel::Accelerator& accelerator,
                                                   std::span<const accel::Ray> rays);

} // namespace kindling::app
