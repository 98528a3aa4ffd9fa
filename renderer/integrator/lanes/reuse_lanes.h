// Links between the paths of several pixels, in lanes: of groups of eight together.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/integrator/stages/reuse_paths.h"

#include <array>
#include <cstdint>

namespace kindling {

// The links of one place of the group of each of eight paths: lane i has the link from path i to
// path i ^ place. ReuseLink, but without what share_group() computes.
struct LinkLanes {
  LaneVectors value, direction; // direction: unit, to the second surface
  LaneNumbers density;          // 0: they are not joined
};
using GroupLinks = std::array<LinkLanes, kMaxPathReuse>; // by place

// The rays of links, by place.
struct LinkRays {
  std::array<LaneRows, kMaxPathReuse> halves; // the first halves
  std::array<uint8_t, kMaxPathReuse> traced;  // a bit for each lane that has a ray
};

// ReuseView::link_paths() and link_ray() for all paths of a group, with the same bits: `group` is
// that of its first path, whatever the number of places that are shared.
void link_group(const PathStages& stages, const ReuseView& view, const ReuseGroup& group, GroupLinks& links,
                LinkRays& rays);
// ReuseView::share_light() and receive() for all of them. Blocked links have a density of 0.
void share_group(const ReuseView& view, const ReuseGroup& group, const GroupLinks& links, PathState* states);

} // namespace kindling
