// Uniform samples of the solid angle of a triangle.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/sampling/sincos_turns.h"

namespace kindling {

// A triangle as seen from a point, uniform by solid angle; with Lanes, eight of each.
//
// Stratified as in Arvo 1995, "Stratified Sampling of Spherical Triangles": u.x cuts off a part of
// the solid angle, u.y moves along an arc. Computed without angles as in Peters 2021, "BRDF
// Importance Sampling for Polygonal Lights" (section 4), with two changes that keep it accurate for
// triangles of any size, so that no fallback to area sampling is needed: the triple product is
// computed from the edges instead of the unit vectors, and barycentrics are computed from the
// sampled combination of the corners instead of an intersection.
template <typename Real>
class SphericalTriangleOf {
 public:
  using Point = Imath::Vec3<Real>;
  struct Sample {
    Point direction;                // unit, from the reference point
    Imath::Vec2<Real> barycentrics; // point on the triangle: p = (1 - x - y) p0 + x p1 + y p2
  };

  SphericalTriangleOf(const Point& p0, const Point& p1, const Point& p2, const Point& reference);

  // Returns the solid angle in [0, 2 pi), for either orientation; 0 if degenerate or edge-on.
  [[nodiscard]] Real solid_angle() const { return 2.0f * half_solid_angle_; }
  // Returns the sample of u in [0, 1)^2; undefined numbers if the solid angle is 0.
  [[nodiscard]] Sample sample(const Imath::Vec2<Real>& u) const;
  // Returns the density by solid angle of each direction through the triangle; 0 if degenerate.
  [[nodiscard]] Real pdf() const {
    return select(half_solid_angle_ > 0.0f, Real(0.5f / half_solid_angle_), Real(0.0f));
  }

 private:
  Point corner_[3];          // unit vectors from the reference point
  Real inverse_distance_[3]; // to the corners
  Real g0_;                  // |triple product| of the unit corners
  Real g1_;                  // c0 c2 + c1 c2
  Real g2_;                  // 1 + c0 c1
  Real half_solid_angle_;
};

using SphericalTriangle = SphericalTriangleOf<float>;

template <typename Real>
inline SphericalTriangleOf<Real>::SphericalTriangleOf(const Point& p0, const Point& p1, const Point& p2,
                                                      const Point& reference) {
  const Point points[3] = {p0 - reference, p1 - reference, p2 - reference};
  for (int i = 0; i < 3; ++i) {
    inverse_distance_[i] = 1.0f / square_root(points[i].length2());
    corner_[i] = points[i] * inverse_distance_[i];
  }
  g0_ = absolute(points[0].dot((p1 - p0).cross(p2 - p0))) * inverse_distance_[0] * inverse_distance_[1] *
        inverse_distance_[2];
  g1_ = corner_[0].dot(corner_[2]) + corner_[1].dot(corner_[2]);
  g2_ = 1.0f + corner_[0].dot(corner_[1]);
  // Van Oosterom and Strackee 1983. The comparisons also treat NaN (the reference is a corner) as
  // degenerate.
  const auto seen = (g0_ > 0.0f) & (g0_ < kInfinity) & (g2_ > 0.0f);
  half_solid_angle_ = select(seen, elementary::atan2(g0_, g1_ + g2_), Real(0.0f));
}

template <typename Real>
inline typename SphericalTriangleOf<Real>::Sample SphericalTriangleOf<Real>::sample(const Imath::Vec2<Real>& u) const {
  // The triangle of corners 0, 1 and q has the solid angle u.x * solid_angle; q is on the arc from
  // corner 0 to corner 2.
  const SinCosOf<Real> half = sincos_turns(u.x * half_solid_angle_ * (0.5f * kInvPi));
  const Real c0 = maximum(g0_ * half.cos - g1_ * half.sin, Real(0.0f));
  const Real c2 = g2_ * half.sin;
  const Point middle = corner_[0] * c0 + corner_[2] * c2;
  const Real length2 = middle.length2();
  const auto apart = length2 > 0.0f;
  const Real scale = select(apart, 2.0f * corner_[0].dot(middle) / length2, Real(1.0f));
  const Real q0 = select(apart, scale * c0 - 1.0f, Real(1.0f));
  const Real q2 = scale * c2;
  const Point q = corner_[0] * q0 + corner_[2] * q2;
  // The direction moves from corner 1 (u.y = 0) toward q; h = 1 - cos of the arc is computed from
  // the difference vector, which is accurate for short arcs.
  const Real h = 0.5f * (corner_[1] - q).length2();
  const Real step = u.y * h;
  const Real t = square_root(maximum(u.y * (2.0f - step) / maximum(2.0f - h, Real(1e-12f)), Real(0.0f)));
  const Real weights[3] = {maximum(t * q0, Real(0.0f)), maximum(1.0f - step - t * (1.0f - h), Real(0.0f)),
                           maximum(t * q2, Real(0.0f))};
  const Real b0 = weights[0] * inverse_distance_[0];
  const Real b1 = weights[1] * inverse_distance_[1];
  const Real b2 = weights[2] * inverse_distance_[2];
  const Real inverse_sum = 1.0f / (b0 + b1 + b2);
  const Point direction = corner_[0] * weights[0] + corner_[1] * weights[1] + corner_[2] * weights[2];
  return {direction * (1.0f / square_root(direction.length2())), {b1 * inverse_sum, b2 * inverse_sum}};
}

} // namespace kindling
