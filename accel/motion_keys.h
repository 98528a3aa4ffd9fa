// Key intervals and linear interpolation between keys, which compile for any processor.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ImathMatrix.h>
#include <ImathVec.h>

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <span>

namespace kindling::accel {

// A position between key `first` and the next, at `fraction` in [0, 1].
struct KeyInterval {
  uint32_t first = 0;
  float fraction = 0.0f;
};

// Clamps a time to [0, 1]; NaN becomes 0.
[[nodiscard]] inline float clamped_time(float time) { return time > 0.0f ? std::min(time, 1.0f) : 0.0f; }

// Returns the interval of `time`, in [0, 1], among `segments` >= 1 intervals between keys. Never
// leaves the keys; `first` grows monotonically with time.
[[nodiscard]] inline KeyInterval key_interval(float time, uint32_t segments) {
  assert(time >= 0.0f && time <= 1.0f && segments >= 1);
  const float at = time * static_cast<float>(segments);
  const uint32_t first = std::min(static_cast<uint32_t>(at), segments - 1);
  return {first, at - static_cast<float>(first)};
}

// Linear interpolation; equal ends give the same bits.
[[nodiscard]] inline float between(float a, float b, float fraction) { return a + (b - a) * fraction; }
[[nodiscard]] inline Imath::V3f between(const Imath::V3f& a, const Imath::V3f& b, float fraction) {
  return {between(a.x, b.x, fraction), between(a.y, b.y, fraction), between(a.z, b.z, fraction)};
}
// Interpolates the affine part; the last column is the identity's.
[[nodiscard]] inline Imath::M44f between(const Imath::M44f& a, const Imath::M44f& b, float fraction) {
  Imath::M44f m;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 3; ++column) m[row][column] = between(a[row][column], b[row][column], fraction);
  return m;
}

// Returns the interpolated matrix; needs at least two keys. The time is clamped.
[[nodiscard]] inline Imath::M44f matrix_at(std::span<const Imath::M44f> keys, float time) {
  assert(keys.size() >= 2);
  const KeyInterval at = key_interval(clamped_time(time), static_cast<uint32_t>(keys.size() - 1));
  return between(keys[at.first], keys[at.first + 1], at.fraction);
}

} // namespace kindling::accel
