// Shadow rays one by one, through thin walls.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/stages/path_stages.h"

#include <cstdint>

namespace kindling {

// Traces a shadow ray, which has kPassThinWalls. True if it reaches its light; thin walls on the
// way tint the contribution. Adds the number of rays to `rays`.
inline bool reaches_light(const PathStages& stages, accel::Ray ray, Rgb& contribution, uint32_t& rays) {
  const WorldView& world = *stages.world;
  ++rays;
  if (world.probe_is_blocked(ray)) return false;
  if (!world.has_thin_walls) return true;
  ray.flags = kHitThinWalls;
  SurfacePoint scratch;
  for (uint32_t thin_wall = 0; thin_wall < kMaxTransparentSurfaces; ++thin_wall) {
    const accel::Hit hit = world.probe_hit(ray);
    ++rays;
    if (!hit.is_hit()) return true;
    const PathStages::ThinWall wall = stages.pass_thin_wall(hit, ray, scratch, contribution);
    if (wall == PathStages::ThinWall::blocks) return false;
    if (wall == PathStages::ThinWall::last) return true;
  }
  return false; // behind too many thin walls
}

} // namespace kindling
