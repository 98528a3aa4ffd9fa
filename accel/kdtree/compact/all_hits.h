// Every crossing of one ray over a view, in scalars.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/crossing_collector.h"
#include "accel/kdtree/compact/queries.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace kindling::accel::kd::compact {

// The query of all_hits(). A cell refers to all triangles that may be hit in it, so a triangle may
// be found in several cells, each time with the same bits.
template <class Filter>
class AllHitsQuery : public TreeVisits<false, AllHitsQuery<Filter>> {
  using Visits = TreeVisits<false, AllHitsQuery>;
  friend Visits;

 public:
  AllHitsQuery(const StructureView& view, const Ray& ray, const Filter& filter, Stacks& stacks,
               CrossingCollector& collector)
      : Visits(view, ray, stacks), filter_(filter), collector_(collector) {}

 private:
  template <class Motion>
  bool trace_tree(const TreeView& tree, const Motion& motion, const Ray& ray, uint32_t instance) {
    const auto cross = [&](const TreeHit& candidate, bool front, bool filtered) {
      const Hit hit = tree.resolve(candidate, instance);
      if (!filtered || filter_(Visits::ray_, hit)) collector_.add({hit, front});
      Visits::t_far_ = collector_.t_far();
    };
    TreeWalk(tree, motion, ray, Visits::t_min_).cross(Visits::stacks_.tree, Visits::t_far_, cross);
    return false;
  }

  const Filter& filter_;
  CrossingCollector& collector_;
};

// Sets `crossings` as Accelerator::all_hits() does. The filter is that of queries.h.
template <class Filter>
inline void all_hits(const StructureView& view, const Ray& world, size_t limit, const Filter& filter,
                     std::vector<Crossing>& crossings) {
  CrossingCollector collector(crossings, limit, std::min(world.t_max, std::numeric_limits<float>::max()));
  if (!can_hit(world)) return;
  Stacks stacks;
  AllHitsQuery(view, world, filter, stacks, collector).run();
  collector.finish();
}

} // namespace kindling::accel::kd::compact
