// Single rays of shading by the compact queries of a kd-tree, as on a device.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/queries.h"
#include "renderer/base/on_gpu.h"
#include "renderer/world/world_view.h"

namespace kindling {

// The filter of all rays of paths.
struct CoverageFilter {
  const WorldView& world;
  KINDLING_CALLED_ON_GPU bool operator()(const accel::Ray& ray, const accel::Hit& candidate) const {
    return world.accepts(ray, candidate);
  }
};

// The same for rays with kCameraRay. It looks for no face that is cut away, so that
// WorldView::is_cut_away() does not call itself: a device wants to know the depth of its stack.
struct SightFilter {
  const WorldView& world;
  KINDLING_CALLED_ON_GPU bool operator()(const accel::Ray& ray, const accel::Hit& candidate) const {
    if (world.hides_backs) {
      if (world.is_hidden_back(ray, candidate)) return false;
      if (world.covers[candidate.mesh] != 0) return true;
    }
    return world.accepts_by_coverage(ray, candidate);
  }
};

[[nodiscard]] inline accel::Hit compact_probe_hit(const WorldView& world, const accel::Ray& ray) {
  return accel::kd::compact::intersect(*world.tree, ray, CoverageFilter{world});
}
[[nodiscard]] inline bool compact_probe_is_blocked(const WorldView& world, const accel::Ray& ray) {
  return accel::kd::compact::occluded(*world.tree, ray, CoverageFilter{world});
}
[[nodiscard]] inline bool compact_sight_is_blocked(const WorldView& world, const accel::Ray& ray) {
  return accel::kd::compact::occluded(*world.tree, ray, SightFilter{world});
}

} // namespace kindling
