// A cone around the directions of a moving light.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary.h"
#include "renderer/light/light_frame.h"

#include <algorithm>
#include <span>

namespace kindling {

// A cone that contains the z axes of all frames and of the interpolation between them.
struct Cone {
  V3f axis; // unit
  float angle = 0.0f;
};
[[nodiscard]] inline Cone cone_of_axes(const V3f& first_axis, std::span<const LightFrame> frames) {
  if (frames.empty()) return {first_axis, 0.0f};
  V3f sum(0.0f);
  for (const LightFrame& frame : frames) sum += frame.z;
  Cone result{sum.length() > 1e-3f ? sum.normalized() : first_axis, 0.0f};
  for (const LightFrame& frame : frames)
    result.angle = std::max(result.angle, elementary::acos(std::clamp(frame.z.dot(result.axis), -1.0f, 1.0f)) + 1e-3f);
  if (!(result.angle < 0.5f * kPi)) result.angle = kPi; // caps are convex up to half of the sphere
  return result;
}

} // namespace kindling
