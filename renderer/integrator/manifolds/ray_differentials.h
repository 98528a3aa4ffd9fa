// A ray and how it changes with the direction in which its path began.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <array>
#include <cmath>

namespace kindling {

// The triangle that a ray has hit, in world space.
struct SpecularFace {
  V3f plane_normal; // of any length and side
  // The shading normal on the ray's side, and its change along the plane: that of barycentrics
  // times the normals of the vertices, on the same side, without and with the division by a length.
  V3f normal;                            // unit
  float normal_length = 1.0f;            // of the interpolated normal before it was divided by it
  std::array<V3f, 3> corner_normals;     // on the ray's side; equal where there are none
  std::array<V3f, 3> barycentric_change; // per meter

  // Returns the change of the unit normal with a change of the position in the plane.
  [[nodiscard]] V3f normal_change(const V3f& position_change) const {
    V3f change(0.0f);
    for (size_t i = 0; i < 3; ++i) change += corner_normals[i] * barycentric_change[i].dot(position_change);
    return (change - normal * normal.dot(change)) / normal_length;
  }
};

// A ray from a fixed point on, with the derivatives of its origin and its direction by two
// coordinates of the direction in which it left that point (Igehy 1999, "Tracing Ray
// Differentials"). The coordinates are lengths along two axes perpendicular to that direction, so
// that their product is a solid angle.
struct DifferentialRay {
  V3f origin, direction; // direction: unit
  std::array<V3f, 2> origin_change, direction_change;

  // Moves the origin to a hit at `distance` (in units of the direction).
  void transfer(const SpecularFace& face, const V3f& hit, float distance) {
    const float along = direction.dot(face.plane_normal);
    for (size_t i = 0; i < 2; ++i) {
      const V3f change = origin_change[i] + direction_change[i] * distance;
      origin_change[i] = change - direction * (change.dot(face.plane_normal) / along);
    }
    origin = hit;
  }

  // Reflects the ray at its origin.
  void reflect(const SpecularFace& face) {
    const V3f& n = face.normal;
    const float cosine = direction.dot(n);
    for (size_t i = 0; i < 2; ++i) {
      const V3f dn = face.normal_change(origin_change[i]);
      const float change = direction_change[i].dot(n) + direction.dot(dn);
      direction_change[i] -= (dn * cosine + n * change) * 2.0f;
    }
    direction = (direction - n * (2.0f * cosine)).normalized();
  }

  // Refracts the ray into a medium whose index is `eta` times that of the ray's. False: it is
  // totally reflected.
  [[nodiscard]] bool refract(const SpecularFace& face, float eta) {
    const V3f& n = face.normal;
    const float ratio = 1.0f / eta;
    const float cosine = -direction.dot(n);
    const float beyond2 = 1.0f - ratio * ratio * (1.0f - cosine * cosine);
    if (!(beyond2 > 0.0f && cosine > 0.0f)) return false;
    const float beyond = std::sqrt(beyond2);
    const float bent = ratio * cosine - beyond;
    const float bent_by_cosine = ratio - ratio * ratio * cosine / beyond;
    for (size_t i = 0; i < 2; ++i) {
      const V3f dn = face.normal_change(origin_change[i]);
      const float change = -(direction_change[i].dot(n) + direction.dot(dn)); // of the cosine
      direction_change[i] = direction_change[i] * ratio + dn * bent + n * (bent_by_cosine * change);
    }
    direction = (direction * ratio + n * bent).normalized();
    return true;
  }
};

} // namespace kindling
