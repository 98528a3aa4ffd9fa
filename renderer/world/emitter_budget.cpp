// Selects the emitter groups that fit into the budget.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/emitter_budget.h"

#include <algorithm>
#include <numeric>

namespace kindling {

SampledEmitters choose_sampled_emitters(std::span<const Emitters> groups, uint64_t max_triangles) {
  const auto lights = [&](size_t group) { return groups[group].triangles * groups[group].instances; };
  std::vector<size_t> order(groups.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    const bool once_a = groups[a].instances <= 1, once_b = groups[b].instances <= 1;
    return once_a != once_b ? once_a : lights(a) < lights(b);
  });
  SampledEmitters sampled;
  sampled.groups.resize(groups.size(), 0);
  uint64_t total = 0;
  for (const size_t group : order) {
    if (lights(group) == 0) continue;
    total += lights(group);
    if (total <= max_triangles || groups[group].instances == 1)
      sampled.groups[group] = 1;
    else
      sampled.left_out += lights(group);
  }
  return sampled;
}

} // namespace kindling
