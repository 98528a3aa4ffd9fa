// The scalar watertight ray-triangle test, and the rules for triangles and rays that cannot hit.
//
// After Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013: the triangle
// is sheared so that the ray runs along its largest axis, then the origin is tested against the
// three edges. The edge functions have the sign of the exact ones, so the two triangles at an edge
// agree, and no ray can pass between them. This holds only while the compiler fuses no product with
// a sum by itself (-ffp-contract=off). Departures: axes are not permuted by the sign of the
// direction, because both facings are accepted; there is no second try in double precision, because
// signs are exact and an edge value of zero counts as inside. kdtree/kernels/leaf_test.h has the
// same operations in the same order for sixteen triangles at a time; results are equal bit for bit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"

#include <cassert>
#include <cmath>

namespace kindling::accel {

// Per-ray values of the test, computed once per ray and space.
struct RayShear {
  int kx = 0, ky = 1, kz = 2; // axis of the direction's largest component
  float sx = 0.0f, sy = 0.0f; // shear
  float sz = 1.0f;            // 1 / direction[kz]
  Imath::V3f origin;          // components in the order kx, ky, kz

  RayShear() = default;
  RayShear(const Imath::V3f& o, const Imath::V3f& d) {
    const float ax = std::fabs(d.x), ay = std::fabs(d.y), az = std::fabs(d.z);
    kz = ax > ay ? (ax > az ? 0 : 2) : (ay > az ? 1 : 2);
    kx = kz == 2 ? 0 : kz + 1;
    ky = kx == 2 ? 0 : kx + 1;
    const float* dp = &d.x;
    const float* op = &o.x;
    assert(dp[kz] != 0.0f);
    sx = dp[kx] / dp[kz];
    sy = dp[ky] / dp[kz];
    sz = 1.0f / dp[kz];
    origin = {op[kx], op[ky], op[kz]};
  }
};

// A hit lies within this part of the triangle's extent E (its largest range along an axis) of some
// point of the triangle along each axis, and within kDistanceTolerance of its distance along that
// axis; a traversal must enter all cells that are so near.
//
// With u = 2^-24, to first order: the edge functions e_i of the sheared corners (x_i, y_i) are off
// by a factor of 1 +- 2 u, and weigh the corners as w_i = e_i / sum e_i, none below 0. Exact ones
// would give sum w_i x_i = 0; rounding leaves at most 2 u sum w_i |x_i|. The mean distance of
// weighted values from their mean is at most half their range, so
//   sum w_i |z_i| <= |z| + E / 2 with z = sum w_i z_i, and
//   sum w_i |x_i| <= E, since shears are at most 1.
// The depth t d_z differs from z by 3 u sum w_i |z_i| (products and sums) + 5 u |z| (det, sz, a
// product and a quotient): 1.5 u E + 8 u |z|. Differences of depths add u sum w_i |z_i|: along z a
// hit is off by 2 u E + 9 u |z|. Along x, the differences of coordinates add 0.5 u E + u |s_x z|,
// the products s_x z_i as much, the sheared differences u E, the edge functions 2 u E and the shear
// u |s_x z|: together with the depth 5.5 u E + 11 u |s_x z|. Half a unit is left for products of
// errors.
inline constexpr float kExtentTolerance = 6.0f * 0x1p-24f, kDistanceTolerance = 11.0f * 0x1p-24f;

// Returns a b - c d with a relative error of at most 2 u, so the sign is exact (Jeannerod, Louvet,
// Muller, "Further analysis of Kahan's algorithm for the accurate computation of 2 x 2
// determinants", Math. Comp. 82, 2013). Differences of rounded products would be noise for a
// triangle that is seen edge-on, and so would the distance.
[[nodiscard]] inline float difference_of_products(float a, float b, float c, float d) {
  const float product = c * d;
  const float error = __builtin_fmaf(-c, d, product);
  return __builtin_fmaf(a, b, -product) + error;
}

// A corner of a triangle relative to the ray's origin, sheared so that the ray runs along z.
struct ShearedCorner {
  float x, y, z;

  // Takes the coordinates in the order kx, ky, kz.
  ShearedCorner(const RayShear& ray, float px, float py, float pz)
      : x(px - ray.origin.x), y(py - ray.origin.y), z(pz - ray.origin.z) {
    x = x - ray.sx * z;
    y = y - ray.sy * z;
  }
  // Takes coordinates that are sheared already.
  ShearedCorner(float sheared_x, float sheared_y, float depth) : x(sheared_x), y(sheared_y), z(depth) {}
};

// A crossing of a triangle by the line of a ray. u and v (see Hit) are quotients, which many
// queries need of the last crossing alone.
struct ShearedCrossing {
  float t = 0.0f;
  float e1 = 0.0f, e2 = 0.0f, det = 1.0f;

  [[nodiscard]] float u() const { return e1 / det; }
  [[nodiscard]] float v() const { return e2 / det; }
};

// Returns true if the line of the ray crosses the triangle at t in (t_min, t_max]; sets `crossing`
// only then. Callers pass a finite t_max, so that no hit is at infinity.
[[nodiscard]] inline bool find_crossing(const ShearedCorner& a, const ShearedCorner& b, const ShearedCorner& c,
                                        float sz, float t_min, float t_max, ShearedCrossing& crossing) {
  const float e0 = difference_of_products(c.x, b.y, c.y, b.x), e1 = difference_of_products(a.x, c.y, a.y, c.x),
              e2 = difference_of_products(b.x, a.y, b.y, a.x);
  const bool inside = (e0 >= 0.0f && e1 >= 0.0f && e2 >= 0.0f) || (e0 <= 0.0f && e1 <= 0.0f && e2 <= 0.0f);
  const float det = (e0 + e1) + e2;
  if (!inside || det == 0.0f) return false;
  const float distance = (((e0 * a.z + e1 * b.z) + e2 * c.z) * sz) / det;
  if (!(distance > t_min && distance <= t_max)) return false;
  crossing = {distance, e1, e2, det};
  return true;
}
// The same with u and v.
[[nodiscard]] inline bool intersect_sheared(const ShearedCorner& a, const ShearedCorner& b, const ShearedCorner& c,
                                            float sz, float t_min, float t_max, float& t, float& u, float& v) {
  ShearedCrossing crossing;
  if (!find_crossing(a, b, c, sz, t_min, t_max, crossing)) return false;
  t = crossing.t;
  u = crossing.u();
  v = crossing.v();
  return true;
}
// The same for corners that are not sheared yet.
[[nodiscard]] inline bool intersect_triangle(const RayShear& ray, const Imath::V3f& p0, const Imath::V3f& p1,
                                             const Imath::V3f& p2, float t_min, float t_max, float& t, float& u,
                                             float& v) {
  const auto sheared = [&](const Imath::V3f& p) { return ShearedCorner(ray, p[ray.kx], p[ray.ky], p[ray.kz]); };
  return intersect_sheared(sheared(p0), sheared(p1), sheared(p2), ray.sz, t_min, t_max, t, u, v);
}

// Returns the side of the directed edge from p to q on which the ray passes: the sign of an edge
// function, which is that of intersect_sheared() bit for bit. If that is zero, the ray is displaced
// along x and, by infinitely less, along y (Edelsbrunner and Muecke, "Simulation of simplicity",
// ACM TOG 9(1), 1990). The answer depends on the two corners alone and is opposite for the edge
// from q to p.
[[nodiscard]] inline bool passes_left(const ShearedCorner& p, const ShearedCorner& q) {
  const float side = difference_of_products(q.x, p.y, q.y, p.x);
  if (side != 0.0f) return side < 0.0f;
  return p.y != q.y ? p.y > q.y : q.x > p.x;
}

// Returns true if a triangle that intersect_sheared() reports as hit is crossed: the displaced ray
// passes strictly inside of it. All triangles see the same displacement, so a mesh is crossed as by
// a ray that meets no edge. Sets `front` (see Crossing) only then.
[[nodiscard]] inline bool crosses_sheared(const ShearedCorner& a, const ShearedCorner& b, const ShearedCorner& c,
                                          float sz, bool& front) {
  const bool left = passes_left(a, b);
  if (passes_left(b, c) != left || passes_left(c, a) != left) return false;
  front = left == (sz < 0.0f); // axes are permuted cyclically, and x, y, -z sees the corners as they are
  return true;
}

// Coordinates beyond this bound count as not finite, since their products would overflow. Embree
// uses the same bound.
inline constexpr float kMaxCoordinate = 1.844e18f;

[[nodiscard]] inline bool is_finite(const Imath::V3f& p) {
  return std::fabs(p.x) <= kMaxCoordinate && std::fabs(p.y) <= kMaxCoordinate && std::fabs(p.z) <= kMaxCoordinate;
}

// Returns false for triangles that are never hit: a vertex is not finite, or the area is zero
// (exact for coordinates of similar magnitude).
[[nodiscard]] inline bool can_be_hit(const Imath::V3f& p0, const Imath::V3f& p1, const Imath::V3f& p2) {
  if (!is_finite(p0) || !is_finite(p1) || !is_finite(p2)) return false;
  const Imath::V3d a = Imath::V3d(p1) - Imath::V3d(p0), b = Imath::V3d(p2) - Imath::V3d(p0);
  return a.y * b.z != a.z * b.y || a.z * b.x != a.x * b.z || a.x * b.y != a.y * b.x;
}

// Returns false for rays that miss by definition: not finite (see kMaxCoordinate), without
// direction, or with an empty or NaN interval. A t_min below 0 counts as 0. `extent`: upper bound
// of the accepted sum of magnitudes. Free of branches.
[[nodiscard, gnu::always_inline]] inline bool can_hit(const Ray& ray, float extent = kMaxCoordinate) {
  const float sum = (std::fabs(ray.origin.x) + std::fabs(ray.origin.y) + std::fabs(ray.origin.z)) +
                    (std::fabs(ray.direction.x) + std::fabs(ray.direction.y) + std::fabs(ray.direction.z));
  const bool points = (ray.direction.x != 0.0f) | (ray.direction.y != 0.0f) | (ray.direction.z != 0.0f);
  return (sum <= extent) & points & (ray.t_min < ray.t_max) & (ray.t_max > 0.0f);
}

} // namespace kindling::accel
