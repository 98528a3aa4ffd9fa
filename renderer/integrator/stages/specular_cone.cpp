// Cones of paths that have met nothing but glass, mirrors and narrow lobes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/specular_cone.h"

#include "renderer/world/curvature.h"

#include <algorithm>
#include <cmath>

namespace kindling {

// Rays of a bundle diverge by the difference of the normals where they meet the surface: a mirror
// doubles it, refraction multiplies it by (eta_i cos_i - eta_t cos_t) / eta_t (Igehy 1999, "Tracing
// Ray Differentials", equations 15 and 18, across the plane of incidence). Its sign, by which a
// lens may focus the bundle, is left out: behind a few surfaces of an uneven solid a bundle
// diverges in one direction or the other, whatever the others did.
RayCone specular_cone(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface, const V3f& wi,
                      float eta, const RayCone& arriving) {
  const float bend = curvature_at(world, hit) * arriving.width_m;
  const float cosine = std::abs(wi.dot(surface.shading_normal));
  if (wi.dot(surface.geometric_normal) > 0.0f) return {arriving.width_m, arriving.spread + 2.0f * cosine * bend};
  const float sine2_before = std::min(eta * eta * (1.0f - cosine * cosine), 1.0f);
  const float refraction = std::abs(std::sqrt(1.0f - sine2_before) / eta - cosine);
  return {arriving.width_m, arriving.spread / eta + refraction * bend};
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
