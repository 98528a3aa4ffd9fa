// Position and orientation of a punctual light, static or over the shutter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/motion.h"
#include "renderer/base/math.h"

#include <cassert>
#include <cstdint>
#include <span>

namespace kindling {

// Position and axes of a light in world space; it is aimed along -z. Axes are unit.
struct LightFrame {
  V3f position{0.0f};
  V3f x{1.0f, 0.0f, 0.0f}, y{0.0f, 1.0f, 0.0f}, z{0.0f, 0.0f, 1.0f};
};

// Interpolates as a (1 - fraction) + b fraction.
[[nodiscard]] inline V3f between(const V3f& a, const V3f& b, float fraction) {
  return a * (1.0f - fraction) + b * fraction;
}

// Returns the frame at `time` in [0, 1], given at least two keys. Positions and axes are
// interpolated linearly, like the matrix entries of moving instances; axes are then normalized.
[[nodiscard]] inline LightFrame frame_at(std::span<const LightFrame> keys, float time) {
  assert(keys.size() >= 2);
  const accel::KeyInterval at = accel::key_interval(accel::clamped_time(time), static_cast<uint32_t>(keys.size() - 1));
  const LightFrame &a = keys[at.first], &b = keys[at.first + 1];
  return {between(a.position, b.position, at.fraction), between(a.x, b.x, at.fraction).normalized(),
          between(a.y, b.y, at.fraction).normalized(), between(a.z, b.z, at.fraction).normalized()};
}

} // namespace kindling
