// Directions as points of a square: the octahedron, unfolded.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cmath>
#include <cstdint>

namespace kindling {

// The octahedron |x| + |y| + |z| = 1 is seen along its z axis; its four lower faces are folded
// outwards to the corners of the square (Praun and Hoppe 2003, "Spherical Parametrization and
// Remeshing"). Sums, quotients and one square root lead there and back.

// Returns the point of a direction, in [0, 1]^2. It need not be a unit vector.
[[nodiscard]] inline V2f point_of_direction(const V3f& direction) {
  const float scale = 1.0f / (std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z));
  const float x = direction.x * scale, y = direction.y * scale;
  if (direction.z >= 0.0f) return {0.5f + 0.5f * x, 0.5f + 0.5f * y};
  return {0.5f + std::copysign(0.5f - 0.5f * std::abs(y), x), 0.5f + std::copysign(0.5f - 0.5f * std::abs(x), y)};
}

// Returns the unit vector of a point of [0, 1]^2.
[[nodiscard]] inline V3f direction_of_point(const V2f& point) {
  float x = 2.0f * point.x - 1.0f, y = 2.0f * point.y - 1.0f;
  const float z = 1.0f - std::abs(x) - std::abs(y);
  if (z < 0.0f) {
    const float folded = std::copysign(1.0f - std::abs(y), x);
    y = std::copysign(1.0f - std::abs(x), y);
    x = folded;
  }
  return V3f(x, y, z).normalized();
}

// Returns the solid angle of a small part of the square over its area, at the point of a unit
// direction: between 4 and 20.8 steradians.
[[nodiscard]] inline float steradians_per_area(const V3f& direction) {
  const float sum = std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z);
  return 4.0f * (sum * sum * sum);
}

// Returns the number of the quarter that contains a point: bit 0 for the upper half of x, bit 1
// for that of y.
[[nodiscard]] inline uint32_t quarter_of(const V2f& point) {
  return (point.x >= 0.5f ? 1U : 0U) + (point.y >= 0.5f ? 2U : 0U);
}
// Returns the place of the point within that quarter, in [0, 1]^2.
[[nodiscard]] inline V2f point_in_quarter(const V2f& point, uint32_t quarter) {
  return {2.0f * point.x - static_cast<float>(quarter & 1U), 2.0f * point.y - static_cast<float>(quarter >> 1)};
}

} // namespace kindling
