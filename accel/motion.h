// Motion keys over the shutter: key intervals and linear interpolation of vertices and matrices.
// All accelerators use these functions, so that a vertex or a matrix at a given time has the same
// bits in all of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/motion_keys.h"

#include <ImathMatrix.h>
#include <ImathVec.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling::accel {

[[nodiscard]] inline bool is_finite(std::span<const Imath::M44f> keys) {
  return std::all_of(keys.begin(), keys.end(), [](const Imath::M44f& m) {
    return std::all_of(m.getValue(), m.getValue() + 16, [](float entry) { return std::isfinite(entry); });
  });
}

// Returns the matrix of a moving or static instance at a time.
[[nodiscard]] inline Imath::M44f matrix_at(const BuildInput& input, const Instance& instance, float time) {
  return instance.motion == kNoId ? instance.object_to_world : matrix_at(input.motions[instance.motion], time);
}

[[nodiscard]] inline bool deforms(const TriangleMesh& mesh) { return !mesh.later_positions.empty(); }
// Returns the number of keys: 1 for a static mesh.
[[nodiscard]] inline uint32_t key_count(const TriangleMesh& mesh) {
  return static_cast<uint32_t>(mesh.later_positions.size()) + 1;
}
[[nodiscard]] inline std::span<const Imath::V3f> positions_at_key(const TriangleMesh& mesh, uint32_t key) {
  assert(key < key_count(mesh));
  return key == 0 ? mesh.positions : mesh.later_positions[key - 1];
}

// Vertex positions of a mesh at one time, interpolated on access if it deforms.
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
