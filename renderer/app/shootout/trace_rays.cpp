// The loops over rays that are timed.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/trace_rays.h"

#include "renderer/app/measure/measurement.h"
#include "renderer/base/standard_arithmetic.h"

#include <algorithm>

namespace kindling::app {

namespace {

// The number of rays of one call.
size_t chunk_of(const RaySet& set, CallForm form, uint32_t batch_size) {
  return form == CallForm::coherent && set.coherent_group > 0 ? set.coherent_group : batch_size;
}

// The median time between two consecutive readings of the clock.
double clock_cost_s() {
  std::vector<double> costs;
  for (int i = 0; i < 1001; ++i) {
    const double start = clock_s(ShootoutClock::wall);
    costs.push_back(clock_s(ShootoutClock::wall) - start);
  }
  return median(costs);
}

} // namespace

Answers::Answers(const RaySet& set) {
  if (set.query == RayQuery::nearest)
    hits.resize(set.rays.size());
  else
    occluded.resize(set.rays.size());
}

void trace(const accel::Accelerator& accelerator, const RaySet& set, CallForm form, uint32_t batch_size,
           Answers& answers) {
  const std::span<const accel::Ray> rays(set.rays);
  if (form == CallForm::single) {
    if (set.query == RayQuery::nearest)
      for (size_t i = 0; i < rays.size(); ++i) answers.hits[i] = accelerator.intersect(rays[i]);
    else
      for (size_t i = 0; i < rays.size(); ++i) answers.occluded[i] = accelerator.occluded(rays[i]) ? 1 : 0;
    return;
  }
  const size_t chunk = chunk_of(set, form, batch_size);
  for (size_t begin = 0; begin < rays.size(); begin += chunk) {
    const size_t count = std::min(chunk, rays.size() - begin);
    const std::span<const accel::Ray> part = rays.subspan(begin, count);
    if (set.query == RayQuery::any_hit && form == CallForm::coherent)
      accelerator.occluded_coherent(part, std::span(answers.occluded).subspan(begin, count));
    else if (set.query == RayQuery::any_hit)
      accelerator.occluded(part, std::span(answers.occluded).subspan(begin, count));
    else if (form == CallForm::coherent)
      accelerator.intersect_coherent(part, std::span(answers.hits).subspan(begin, count));
    else
      accelerator.intersect(part, std::span(answers.hits).subspan(begin, count));
  }
}

std::vector<float> time_single_calls(const accel::Accelerator& accelerator, std::span<const accel::Ray> rays) {
  const StandardArithmetic standard_arithmetic;
  std::vector<double> times(rays.size() * kHeatMapRounds);
  std::vector<accel::Hit> hits(rays.size()); // stored, so that the compiler keeps all queries
  for (int round = 0; round < kHeatMapRounds; ++round)
    for (size_t i = 0; i < rays.size(); ++i) {
      const double start = clock_s(ShootoutClock::wall);
      hits[i] = accelerator.intersect(rays[i]);
      times[i * kHeatMapRounds + static_cast<size_t>(round)] = clock_s(ShootoutClock::wall) - start;
    }
  const double clock_cost = clock_cost_s();
  std::vector<float> nanoseconds;
  for (size_t i = 0; i < rays.size(); ++i) {
    const double time = median(std::span(times).subspan(i * kHeatMapRounds, kHeatMapRounds));
    nanoseconds.push_back(static_cast<float>(std::max(0.0, time - clock_cost) * 1e9));
  }
  return nanoseconds;
}

} // namespace kindling::app
