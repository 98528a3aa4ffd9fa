// Cones of paths that have met nothing but clear glass and perfect mirrors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/ray_cone.h"
#include "renderer/world/surface_point.h"
#include "renderer/world/world_view.h"

namespace kindling {

// Returns PathState::specular_cone after a perfect reflection or refraction into wi at a hit, where
// the cone that arrives has its width. `eta` is the index of refraction beyond over that before.
[[nodiscard]] RayCone specular_cone(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface,
                                    const V3f& wi, float eta, const RayCone& arriving);

} // namespace kindling
