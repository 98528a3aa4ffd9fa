// Cones of paths that have met nothing but glass, mirrors and narrow lobes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/ray_cone.h"
#include "renderer/world/surface_point.h"
#include "renderer/world/world_view.h"

namespace kindling {

// Maximum width of the areas of the environment that a path averages, in full turns: wider cones
// are not round.
inline constexpr float kMaxTurns = 0.08f;

// Returns the spread of a cone after a reflection or refraction at a surface, where it arrives with
// `spread` and its rays meet normals that differ by `bend` radians. `cosine` is that between the
// next direction and the shading normal, in [0, 1]; `eta` is the index of refraction beyond over
// that before.
//
// Rays of a bundle diverge by the difference of the normals where they meet the surface: a mirror
// doubles it, refraction multiplies it by (eta_i cos_i - eta_t cos_t) / eta_t (Igehy 1999, "Tracing
// Ray Differentials", equations 15 and 18, across the plane of incidence). Its sign, by which a
// lens may focus the bundle, is left out: behind a few surfaces of an uneven solid a bundle
// diverges in one direction or the other, whatever the others did.
template <typename Real>
[[nodiscard]] Real spread_beyond(const Real& spread, const Real& bend, const Real& cosine,
                                 const MaskOf<Real>& reflected, const Real& eta) {
  return select_result(
      reflected, [&] { return Real(spread + 2.0f * cosine * bend); },
      [&] {
        const Real sine2_before = minimum(Real(eta * eta * (1.0f - cosine * cosine)), Real(1.0f));
        const Real refraction = absolute(Real(square_root(Real(1.0f - sine2_before)) / eta - cosine));
        return Real(spread / eta + refraction * bend);
      });
}

// Returns PathState::specular_cone after a reflection or refraction into wi at a hit, where the
// cone that arrives has its width; `eta` as above.
[[nodiscard]] RayCone specular_cone(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface,
                                    const V3f& wi, float eta, const RayCone& arriving);

// Returns whether the bundle of rays that a cone of this spread stands for is wider than the lobe
// of rough glass around a ray along the normal. `specular_scale` is PathStages::specular_scale. A
// normal that turns by alpha turns the refracted ray by |1 / eta - 1| alpha, to either side.
template <typename Real>
[[nodiscard]] MaskOf<Real> lobe_is_covered(const Real& roughness, const Real& eta, const Real& spread,
                                           float specular_scale) {
  const Real lobe = 2.0f * absolute(Real(1.0f / eta - 1.0f)) * (roughness * roughness);
  return minimum(Real(spread * specular_scale), Real(kMaxTurns)) * (2.0f * kPi) > lobe;
}

// The same of a bundle that leaves the glass at a hit, where it arrives as such a cone.
[[nodiscard]] bool bundle_covers_lobe(const WorldView& world, const accel::Hit& hit, const SurfacePoint& surface,
                                      float eta, const RayCone& arriving, float specular_scale);

} // namespace kindling
