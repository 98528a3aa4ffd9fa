// Points on emissive triangles, sampled as they are seen from a lit point: one, or eight at once.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/sampling/spherical_triangle.h"
#include "renderer/sampling/warp.h"

namespace kindling {

// Eight triangles. In what follows a Triangle is this, or any struct with three such members.
struct TriangleLanes {
  Imath::Vec3<Lanes> p0, p1, p2;
};

// Length: twice the area. Points to the side from which p0, p1, p2 are counterclockwise.
template <typename Triangle>
[[nodiscard]] auto double_area_normal(const Triangle& t) {
  return (t.p1 - t.p0).cross(t.p2 - t.p0);
}

// Returns the solid-angle density of a point that is uniform by area.
template <typename Real>
[[nodiscard]] Real area_density(const Imath::Vec3<Real>& double_area_normal, const Imath::Vec3<Real>& wi,
                                const Real& distance) {
  const Real projected = 0.5f * absolute(double_area_normal.dot(wi));
  return select(projected > 0.0f, Real(distance * distance / projected), Real(0.0f));
}

inline constexpr float kFarInEdges = 2.0f;
// Returns whether points are sampled uniformly by solid angle, else by area: at distances above
// kFarInEdges longest edges, distance and angle hardly vary over a triangle, so area is as good and
// cheaper.
template <typename Triangle, typename Real>
[[nodiscard]] auto sampled_by_solid_angle(const Triangle& t, const Imath::Vec3<Real>& point) {
  const Imath::Vec3<Real> to_centroid = (t.p0 + t.p1 + t.p2) * (1.0f / 3.0f) - point;
  const Real longest2 =
      maximum(Real((t.p1 - t.p0).length2()), maximum(Real((t.p2 - t.p1).length2()), Real((t.p0 - t.p2).length2())));
  return to_centroid.length2() < square(kFarInEdges) * longest2;
}

template <typename Real>
struct PointOnTriangle {
  Imath::Vec3<Real> wi; // unit, from the lit point
  Real distance;
  Real pdf; // solid angle; unless it is positive and finite, all members are undefined
  Imath::Vec2<Real> barycentrics;
};

// Returns the sample of u in [0, 1)^2 as seen from `point`; `normal` is double_area_normal().
template <typename Triangle, typename Real>
[[nodiscard]] PointOnTriangle<Real> sample_point(const Triangle& t, const Imath::Vec3<Real>& normal,
                                                 const Imath::Vec3<Real>& point, const Imath::Vec2<Real>& u) {
  const auto at = [&](const Imath::Vec2<Real>& b) { return t.p0 * (1.0f - b.x - b.y) + t.p1 * b.x + t.p2 * b.y; };
  const auto near = sampled_by_solid_angle(t, point);
  PointOnTriangle<Real> result;
  if (any(near)) {
    const SphericalTriangleOf<Real> seen(t.p0, t.p1, t.p2, point);
    const auto sample = seen.sample(u);
    result = {sample.direction, square_root(Real((at(sample.barycentrics) - point).length2())), seen.pdf(),
              sample.barycentrics};
    if (all(near)) return result;
  }
  const Imath::Vec2<Real> barycentrics = sample_uniform_triangle(u);
  const Imath::Vec3<Real> to_light = at(barycentrics) - point;
  const Real distance = square_root(Real(to_light.length2()));
  const Imath::Vec3<Real> wi = to_light * (1.0f / distance);
  const Real pdf = area_density(normal, wi, distance);
  if (!any(near)) return {wi, distance, pdf, barycentrics};
  return {select(near, result.wi, wi), select(near, result.distance, distance), select(near, result.pdf, pdf),
          select(near, result.barycentrics, barycentrics)};
}

} // namespace kindling
