// Bounds of the rounding errors of watertight triangle tests, computed in double precision.
// The tests are in single precision, such as Embree's. The bounds serve tests and cross-checks of
// accelerators, not tracing.
//
// Notation: u = 2^-24; vertices are relative to the ray's origin and sheared to its direction as in
// triangle.h, with the z axis along the ray.
//  1. A sheared vertex is off by no more than u (|px| + 3 |sx pz| + |x|) in x, likewise in y, and
//     by u |pz| in z. The line of the ray meets the exact triangle where it meets the computed one,
//     except for the largest of these offsets, (ex, ey). The distance changes by (|nx| ex + |ny|
//     ey) / |nz|, where n is the normal in sheared space.
//  2. An edge function ei = cx by - cy bx is off by u (|cx by| + |cy bx| + |ei|) more, and by
//     2^-125 where products are flushed to zero. Weights ei / det that are off by di / det move the
//     distance, a weighted mean of the vertex depths zi, by sum di |zi - z| / |nz|. This is the
//     large term: for a sliver with edges of length L and width w it is of the order of u L^2 / w,
//     not of u times the distance.
//  3. The sums, products and quotients that follow add 10 u times the largest depth. Values flushed
//     to zero there make distances meaningless below a scale of 1e-13, as overflow does above 1e12.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

namespace kindling::accel {

struct TriangleJudgment {
  // Distance at which the line of the ray crosses the plane of the triangle, in lengths of the
  // direction.
  double t = 0.0;
  // Bound of the difference between t and the watertight test's distance; infinity if rounding
  // dominates.
  double t_error = 0.0;
  bool inside = false;  // the line passes inside the triangle or exactly through an edge
  bool at_edge = false; // within rounding of an edge: the test may report either result
};

// Computes the exact crossing and its error bounds. The triangle must satisfy can_be_hit(), and the
// direction must not be zero. `origin_error` and `direction_error` bound the errors that the
// components of the ray already carry before the test.
[[nodiscard]] TriangleJudgment judge_triangle(const Imath::V3f& origin, const Imath::V3f& direction,
                                              const Imath::V3f& p0, const Imath::V3f& p1, const Imath::V3f& p2,
                                              double origin_error = 0.0, double direction_error = 0.0);

// Applies judge_triangle() to a hit. Under an instance it judges the ray in object space and adds
// the rounding of the transform, doubled since implementations may transform rays differently.
[[nodiscard]] TriangleJudgment judge_hit(const BuildInput& input, const Ray& ray, const Hit& hit);

// Returns true if a hit is correct within rounding: its distance lies in the ray's interval, and
// the ray meets its triangle there or passes at an edge.
[[nodiscard]] bool is_possible_hit(const BuildInput& input, const Ray& ray, const Hit& hit);

// Returns true if rounding explains the difference between two nearest hits of one ray, either of
// which may be a miss. The nearer hit must be a possible hit that the other implementation may
// lose: the distances are equal within their errors, or the nearer hit is at an edge, or its exact
// distance lies outside the ray's interval or within the error of an end.
[[nodiscard]] bool rounding_explains(const BuildInput& input, const Ray& ray, const Hit& a, const Hit& b);

} // namespace kindling::accel
