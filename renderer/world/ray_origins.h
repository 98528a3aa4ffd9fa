// Error bounds of hit positions, and the offset of rays that leave them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

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
constexpr float position_bound(float magnitude) { return 3.0f * gamma(7) * magnitude; }

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

// Returns the offset of the position to one side by the error bound of the point.
[[nodiscard]] inline V3f origin_beside(const SurfacePoint& surface, bool beyond) {
  const V3f& n = surface.geometric_normal;
  const float distance = surface.position_error * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  // The bound has a margin for the rounding of this sum.
  return surface.position + n * (beyond ? -distance : distance);
}

} // namespace kindling
