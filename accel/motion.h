// Keys over the shutter: which two a time lies between, and what is interpolated of them. All accelerators use these functions, so
// that one vertex, or one matrix, at one time is the same bits for all.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <ImathMatrix.h>
#include <ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling::accel {

// Between key `first` and the next one, at `fraction` in [0, 1] of the way.
struct KeyInterval {
  uint32_t first = 0;
  float fraction = 0.0f;
};

// NaN counts as 0.
[[nodiscard]] inline float clamped_time(float time) { return time > 0.0f ? std::min(time, 1.0f) : 0.0f; }

// Of `segments` >= 1 intervals between as many keys and one; `time` in [0, 1]. Never leaves the keys; first grows with time.
[[nodiscard]] inline KeyInterval key_interval(float time, uint32_t segments) {
  const float at = time * static_cast<float>(segments);
  const uint32_t first = std::min(static_cast<uint32_t>(at), segments - 1);
  return {first, at - static_cast<float>(first)};
}

// What does not move stays what it is, to the bit.
[[nodiscard]] inline float between(float a, float b, float fraction) { return a + (b - a) * fraction; }
[[nodiscard]] inline Imath::V3f between(const Imath::V3f& a, const Imath::V3f& b, float fraction) {
  return {between(a.x, b.x, fraction), between(a.y, b.y, fraction), between(a.z, b.z, fraction)};
}
// The last column, that of affine matrices, is left as it is.
[[nodiscard]] inline Imath::M44f between(const Imath::M44f& a, const Imath::M44f& b, float fraction) {
  Imath::M44f m;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 3; ++column) m[row][column] = between(a[row][column], b[row][column], fraction);
  return m;
}

// Of at least two keys.
[[nodiscard]] inline Imath::M44f matrix_at(std::span<const Imath::M44f> keys, float time) {
  const KeyInterval at = key_interval(clamped_time(time), static_cast<uint32_t>(keys.size() - 1));
  return between(keys[at.first], keys[at.first + 1], at.fraction);
}

[[nodiscard]] inline bool is_finite(std::span<const Imath::M44f> keys) {
  return std::all_of(keys.begin(), keys.end(), [](const Imath::M44f& m) {
    return std::all_of(m.getValue(), m.getValue() + 16, [](float entry) { return std::isfinite(entry); });
  });
}

// Moving or still.
[[nodiscard]] inline Imath::M44f matrix_at(const BuildInput& input, const Instance& instance, float time) {
  return instance.motion == kNoId ? instance.object_to_world : matrix_at(input.motions[instance.motion], time);
}

[[nodiscard]] inline bool deforms(const TriangleMesh& mesh) { return !mesh.later_positions.empty(); }
// One, or as many as there are for a mesh that deforms.
[[nodiscard]] inline uint32_t key_count(const TriangleMesh& mesh) {
  return static_cast<uint32_t>(mesh.later_positions.size()) + 1;
}
[[nodiscard]] inline std::span<const Imath::V3f> positions_at_key(const TriangleMesh& mesh, uint32_t key) {
  return key == 0 ? mesh.positions : mesh.later_positions[key - 1];
}

// Of a mesh, deforming or still, at a time.
class PositionsAt {
 public:
  PositionsAt(const TriangleMesh& mesh, float time) : first_(mesh.positions.data()), second_(first_) {
    if (!deforms(mesh)) return;
    const KeyInterval at = key_interval(clamped_time(time), key_count(mesh) - 1);
    first_ = positions_at_key(mesh, at.first).data();
    second_ = positions_at_key(mesh, at.first + 1).data();
    fraction_ = at.fraction;
  }
  [[nodiscard]] Imath::V3f operator[](uint32_t vertex) const {
    return first_ == second_ ? first_[vertex] : between(first_[vertex], second_[vertex], fraction_);
  }

 private:
  const Imath::V3f *first_, *second_;
  float fraction_ = 0.0f;
};

} // namespace kindling::accel
