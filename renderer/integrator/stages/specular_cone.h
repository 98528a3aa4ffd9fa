// Cones of paths that have met nothing but glass, mirrors and narrow lobes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/ray_cone.h"
#include "renderer/world/surface_point.h"
#include "renderer/world/world_view.h"

namespace kindling {

// Maximum width of the areas of the environment that a path averages, in full turns: wider cones
// are not round.
inline constexpr float kMaxTurns = 0.08f;

// Returns PathState::specular_cone after a reflection or refraction into wi at a hit, where the
// cone that arrives has its width. `eta` is the index of refraction beyond over that before.
[[nodiscard]] RayCone specular_cone(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface,
                                    const V3f& wi, float eta, const RayCone& arriving);

// Returns whether the bundle of rays that such a cone stands for would leave rough glass wider than
// the lobe of a ray along the normal. `specular_scale` is PathStages::specular_scale.
[[nodiscard]] bool bundle_covers_lobe(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface,
                                      float eta, const RayCone& arriving, float specular_scale);

} // namespace kindling
