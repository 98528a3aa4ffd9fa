// Error bounds of hit positions, and the offset of rays that leave them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/world/surface_point.h"

#include <limits>

namespace kindling {

// Returns the bound of the relative rounding error of n operations: n epsilon / (1 - n epsilon)
// (Higham 2002, section 3.1).
constexpr float gamma(int n) {
  constexpr float kEpsilon = std::numeric_limits<float>::epsilon() * 0.5f;
  return static_cast<float>(n) * kEpsilon / (1.0f - static_cast<float>(n) * kEpsilon);
}

// Returns the error bound of a point interpolated from three others with coordinates up to
// `magnitude`, with a margin for sums computed with it.
template <typename Real>
constexpr Real position_bound(const Real& magnitude) {
  return 3.0f * gamma(7) * magnitude;
}

// The same under an instance: the accelerator intersects in object space, so its rounding there,
// transformed to world space, counts as well.
inline float position_bound(const M44f& m, float object_magnitude, float world_magnitude) {
  const float scale =
      std::max(std::max(max_abs(V3f(m[0][0], m[0][1], m[0][2])), max_abs(V3f(m[1][0], m[1][1], m[1][2]))),
               max_abs(V3f(m[2][0], m[2][1], m[2][2])));
  const float translation = max_abs(V3f(m[3][0], m[3][1], m[3][2]));
  return 3.0f * gamma(10) * (world_magnitude + scale * object_magnitude * 3.0f + translation);
}

// Lengths are multiples of SurfacePoint::position_error.
//
// Closer than this to an edge of its triangle a hit is guarded. An origin is up to sqrt(3) errors
// off its surface, so a neighbor that rises from the edge at an angle of more than about
// atan(sqrt(3) / 8), 12 degrees, cannot be crossed farther away.
inline constexpr float kEdgeMargin = 8.0f;

// Returns the offset of a position to one side of its surface by its error bound. n is the
// geometric normal; `beyond`: to the side that it does not point to.
template <typename Real>
[[nodiscard]] Imath::Vec3<Real> origin_beside(const Imath::Vec3<Real>& position, const Real& error,
                                              const Imath::Vec3<Real>& n, const MaskOf<Real>& beyond) {
  const Real distance = error * (absolute(n.x) + absolute(n.y) + absolute(n.z));
  // The bound has a margin for the rounding of this sum.
  return position + n * select(beyond, Real(-distance), distance);
}
[[nodiscard]] inline V3f origin_beside(const SurfacePoint& surface, bool beyond) {
  return origin_beside<float>(surface.position, surface.position_error, surface.geometric_normal, beyond);
}

// The way of a shadow ray from its origin.
template <typename Real>
struct WayToLight {
  Imath::Vec3<Real> direction; // unit
  Real length;                 // in meters
};
// Returns that of make_shadow_ray() to a light sample, given the position of the surface, the
// origin of the ray, and the sample's direction, distance and normal.
template <typename Real>
[[nodiscard]] WayToLight<Real> way_to_light(const Imath::Vec3<Real>& position, const Imath::Vec3<Real>& origin,
                                            const Imath::Vec3<Real>& wi, const Real& distance,
                                            const Imath::Vec3<Real>& normal) {
  const auto is_near = distance < kInfinity;
  if (!any(is_near)) return {wi, distance};
  // At grazing angles an offset of either end moves the intersection with the light's plane by many
  // times its own size.
  const Imath::Vec3<Real> on_light = position + wi * distance;
  const Real light_error = position_bound(maximum(max_abs(on_light), distance));
  const Imath::Vec3<Real> target =
      on_light + normal * Real(light_error * (absolute(normal.x) + absolute(normal.y) + absolute(normal.z)));
  const Imath::Vec3<Real> to_target = target - origin;
  const Real length = square_root(to_target.length2());
  const auto aims = select(is_near, length, Real(0.0f)) > 0.0f;
  return {select(aims, to_target / length, wi), select(aims, Real(length * (1.0f - gamma(3))), distance)};
}

} // namespace kindling
