// Relative errors of distances in a traversal, and reciprocals of directions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/triangle.h"

#include <cmath>
#include <limits>

namespace kindling::accel::kd {

// Bound of the relative errors of two distances: kDistanceTolerance, and the rounding of the
// distances to planes.
inline constexpr float kRelativeSlack = 2.0f * (kDistanceTolerance + 0x1p-22f);
inline constexpr float kWiden = 1.0f + kRelativeSlack, kBefore = 1.0f - kRelativeSlack;
// Rays are followed this factor beyond their end or nearest hit.
inline constexpr float kBeyond = kWiden * kWiden;

// Returns 1 / d or, where that is infinite, the largest float of its sign. With it no distance to a
// box is NaN, and a ray that lies in a face is on the side of it to which the sign of its zero
// points, as if it were displaced by less than any margin: it needs no order of its own. The ray is
// bent by 2^-128 of its longest component if that is 1. A hit lies closer to its triangle than the
// margin of the cells by 2^-24 of the triangle's extent or more (BuildMeshes), which the bend
// reaches at 2^104 extents; a direction as short as kShortDirection leaves 2^44 of them.
[[nodiscard]] inline float finite_reciprocal(float d) {
  constexpr float kMax = std::numeric_limits<float>::max();
  const float r = 1.0f / d;
  return r > kMax ? kMax : r < -kMax ? -kMax : r;
}

// Returns true if finite_reciprocal() of some component may differ from its reciprocal.
[[nodiscard]] inline bool may_bend(const Imath::V3f& direction) {
  constexpr float kMin = std::numeric_limits<float>::min();
  const float x = std::fabs(direction.x), y = std::fabs(direction.y), z = std::fabs(direction.z);
  return (x < kMin) | (y < kMin) | (z < kMin); // without branches
}

// Shorter rays walk boxes by their direction times kLengthen, and so by distances over it, if they
// may_bend().
inline constexpr float kShortDirection = 0x1p-60f, kLengthen = 0x1p120f, kShorten = 0x1p-120f;
[[nodiscard]] inline bool is_short(const Imath::V3f& direction) {
  const float x = std::fabs(direction.x), y = std::fabs(direction.y), z = std::fabs(direction.z);
  return (x < kShortDirection) & (y < kShortDirection) & (z < kShortDirection);
}

} // namespace kindling::accel::kd
