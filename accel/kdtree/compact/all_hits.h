// Every crossing of one ray over a view, in scalars.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/crossing_collector.h"
#include "accel/kdtree/compact/queries.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace kindling::accel::kd::compact {

// Sets `crossings` as Accelerator::all_hits() does. A cell refers to all triangles that may be hit
// in it, so a triangle may be found in several cells, each time with the same bits. The filter is
// that of queries.h.
template <class Filter>
inline void all_hits(const StructureView& view, const Ray& world, size_t limit, const Filter& filter,
                     std::vector<Crossing>& crossings) {
  CrossingCollector collector(crossings, limit, std::min(world.t_max, std::numeric_limits<float>::max()));
  if (!can_hit(world)) return;
  Stacks stacks;
  const float t_min = std::max(world.t_min, 0.0f);
  const auto trace = [&](const TreeView& tree, const auto& motion, const Ray& ray, uint32_t instance) {
    const auto cross = [&](const TreeHit& candidate, bool front, bool filtered) {
      const Hit hit = tree.resolve(candidate, instance);
      if (!filtered || filter(world, hit)) collector.add({hit, front});
    };
    TreeWalk(tree, motion, ray, t_min).cross(stacks.tree, collector.t_far(), cross);
    return false;
  };
  TreeVisits(view, world, t_min, collector.t_far(), stacks.instances, trace).run();
  collector.finish();
}

} // namespace kindling::accel::kd::compact
