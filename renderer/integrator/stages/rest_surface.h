// Points of moving surfaces where they are in the middle of the shutter interval.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/world_view.h"

#include <algorithm>
#include <cmath>

namespace kindling {

// A point of a surface at rest.
struct RestSurface {
  V3f position;
  V3f normal;              // geometric, unit, on the same side as SurfacePoint::geometric_normal
  float area_ratio = 1.0f; // of its surroundings at rest to those at the time of the hit
};

// Returns the point of a hit at rest. `time`: of the hit. Surfaces that do not move are always at
// rest; a surface without an area there has the ratio 0.
[[nodiscard]] inline RestSurface rest_surface(const WorldView& world, const SurfacePoint& surface,
                                              const accel::Hit& hit, float time) {
  if (!world.instances[hit.instance].moving) return {surface.position, surface.geometric_normal, 1.0f};
  constexpr float kMiddle = 0.5f;
  const auto across = [](const std::array<V3f, 3>& corners) {
    return (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  };
  accel::Ray ray;
  ray.time = time;
  const V3f now = across(world.face_at(ray, hit).corners);
  ray.time = kMiddle;
  const std::array<V3f, 3> corners = world.face_at(ray, hit).corners;
  V3f at_rest = across(corners);
  const float length = at_rest.length(), ratio = length / now.length();
  if (!(ratio > 0.0f && ratio < kInfinity)) return {surface.position, surface.geometric_normal, 0.0f};
  at_rest /= now.dot(surface.geometric_normal) < 0.0f ? -length : length;
  return {corners[0] * (1.0f - hit.u - hit.v) + corners[1] * hit.u + corners[2] * hit.v, at_rest, ratio};
}

} // namespace kindling
