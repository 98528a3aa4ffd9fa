// Where a punctual light is and how it is turned, and both over the shutter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <span>

namespace kindling {

// Place and axes of a light: it is aimed along -z. World space; axes are unit.
struct LightFrame {
  V3f position{0.0f};
  V3f x{1.0f, 0.0f, 0.0f}, y{0.0f, 1.0f, 0.0f}, z{0.0f, 0.0f, 1.0f};
};

// Where among keys, two or more of them and equally far apart over the shutter, a time in [0, 1] is: between `key` and the next.
struct KeyTime {
  size_t key = 0;
  float fraction = 0.0f; // in [0, 1]
};
[[nodiscard]] inline KeyTime key_time(size_t key_count, float time) {
  const float at = std::clamp(time, 0.0f, 1.0f) * static_cast<float>(key_count - 1);
  const size_t key = std::min(static_cast<size_t>(at), key_count - 2);
  return {key, at - static_cast<float>(key)};
}
[[nodiscard]] inline V3f between(const V3f& a, const V3f& b, float fraction) {
  return a * (1.0f - fraction) + b * fraction;
}

// Entries are interpolated linearly, as those of the matrices of moving things, and axes made unit again.
[[nodiscard]] inline LightFrame frame_at(std::span<const LightFrame> keys, float time) {
  const KeyTime at = key_time(keys.size(), time);
  const LightFrame &a = keys[at.key], &b = keys[at.key + 1];
  return {between(a.position, b.position, at.fraction), between(a.x, b.x, at.fraction).normalized(),
          between(a.y, b.y, at.fraction).normalized(), between(a.z, b.z, at.fraction).normalized()};
}

} // namespace kindling
