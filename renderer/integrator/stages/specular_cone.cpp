// Cones of paths that have met nothing but glass, mirrors and narrow lobes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/specular_cone.h"

#include "renderer/world/curvature.h"

#include <algorithm>
#include <cmath>

namespace kindling {

RayCone specular_cone(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface, const V3f& wi,
                      float eta, const RayCone& arriving) {
  const float bend = curvature_at(world, hit) * arriving.width_m;
  const float cosine = std::abs(wi.dot(surface.shading_normal));
  const bool reflected = wi.dot(surface.geometric_normal) > 0.0f;
  return {arriving.width_m, spread_beyond(arriving.spread, bend, cosine, reflected, eta)};
}

bool bundle_covers_lobe(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface, float eta,
                        const RayCone& arriving, float specular_scale) {
  const RayCone leaving = specular_cone(world, hit, surface, -surface.shading_normal, eta, arriving);
  return lobe_is_covered(surface.bsdf.roughness, eta, leaving.spread, specular_scale);
}

} // namespace kindling
