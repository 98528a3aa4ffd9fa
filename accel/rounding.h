// How far rounding may take the answer of the watertight test (triangle.h) from the exact one, judged in double precision:
// for tests and for cross-checks of accelerators, not for tracing.
//
// With u = 2^-24, all vertices relative to the ray's origin and sheared to its direction as in triangle.h, the z axis along the ray:
//  1. A sheared vertex is off by no more than u (|px| + 3 |sx pz| + |x|) in x, likewise in y, and by u |pz| in z. The line of the
//     ray passes the exact triangle where it passes the computed one but for the largest of these offsets, (ex, ey): its
//     distance changes by (|nx| ex + |ny| ey) / |nz|, n being the normal in sheared space.
//  2. An edge function ei = cx by - cy bx is off by u (|cx by| + |cy bx| + |ei|) more, and by 2^-125 where products are flushed to
//     zero. Weights ei / det that are off by di / det move the distance, a mean of the vertices' depths zi, by
//     sum di |zi - z| / |nz|. This is the large one: for a sliver with edges of length L and width w it is of the order of
//     u L^2 / w, and not of u times the distance.
//  3. Sums, products and quotients behind that: 10 u times the largest depth; and what is flushed to zero there, which makes
//     distances worthless below a scale of 1e-13, as overflow does beyond 1e12.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

namespace kindling::accel {

struct TriangleJudgement {
  double t = 0.0; // where the line of the ray crosses the plane of the triangle, in lengths of the direction
  double t_error =
      0.0; // the watertight test, if it finds a hit, has it no farther from t; infinity if the plane is all rounding
  bool inside = false;  // the line passes the triangle inside or exactly at an edge
  bool at_edge = false; // by no more than rounding: the test may say one or the other
};

// The triangle is one that can_be_hit(), the direction not zero. `origin_error` and `direction_error`: how far the components of
// the ray may be off before the test sees them.
[[nodiscard]] TriangleJudgement judge_triangle(const Imath::V3f& origin, const Imath::V3f& direction,
                                               const Imath::V3f& p0, const Imath::V3f& p1, const Imath::V3f& p2,
                                               double origin_error = 0.0, double direction_error = 0.0);

// What two implementations may differ in.
enum class Arithmetic {
  any,  // each has its own test and its own way to transform rays
  same, // both transform rays and test triangles as brute_force does, bit for bit: they differ in what they test
};

// judge_triangle() for a hit; under an instance for the ray in object space, with the rounding of its transform, twice over, if
// implementations may transform it in different ways.
[[nodiscard]] TriangleJudgement judge_hit(const BuildInput& input, const Ray& ray, const Hit& hit,
                                          Arithmetic arithmetic = Arithmetic::any);

// Whether a hit is right within rounding: where it says, in the ray's interval, its triangle met or passed at an edge.
[[nodiscard]] bool is_possible_hit(const BuildInput& input, const Ray& ray, const Hit& hit);

// Of two nearest hits of one ray (either may be none) that differ: whether rounding excuses both. The nearer must be a possible
// hit, and one that the other implementation may lose.
//  any: their distances are equal within their errors; or the nearer is at an edge, or its exact distance within the error of an
//       end of the ray or outside of it.
//  same: exact arithmetic says that the ray does not meet the nearer triangle, or not before the farther hit, or not between its
//       ends, but for the rounding of plane distances. So nothing is lost at an edge that two triangles share.
[[nodiscard]] bool rounding_explains(const BuildInput& input, const Ray& ray, const Hit& a, const Hit& b,
                                     Arithmetic arithmetic = Arithmetic::any);

} // namespace kindling::accel
