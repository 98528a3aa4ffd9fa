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

// A normal that turns by alpha turns the refracted ray by |1 / eta - 1| alpha, to either side.
bool bundle_covers_lobe(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface, float eta,
                        const RayCone& arriving, float specular_scale) {
  const float alpha = surface.bsdf.roughness * surface.bsdf.roughness;
  const float lobe = 2.0f * std::abs(1.0f / eta - 1.0f) * alpha;
  const RayCone leaving = specular_cone(world, hit, surface, -surface.shading_normal, eta, arriving);
  return std::min(leaving.spread * specular_scale, kMaxTurns) * (2.0f * kPi) > lobe;
}

} // namespace kindling
