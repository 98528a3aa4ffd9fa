// Poses the triangle of a hit at the time of its ray.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/world/geometry.h"

#include <array>
#include <optional>
#include <span>

namespace kindling {

// Replaces the arrays of static geometry.
struct MovingHit {
  static constexpr size_t kMaxFloats = 3 + 4 + 4 + 2 * GeometryView::kMaxTexcoordSets; // of a record

  WorldInstance instance;                              // posed at the time of the ray
  std::array<V3f, 3> positions;                        // in the space of the instance
  std::array<std::array<float, kMaxFloats>, 3> copies; // of the records of a deforming mesh
  std::array<const float*, 3> records;                 // these, or the geometry's own
  float error = 0.0f;                                  // bound of the position error from interpolation, meters
};

// Fills `moving` and returns its content. `motions` are WorldView::motions. Between keys
// positions, normals, tangents and the entries of matrices are interpolated linearly; normals and
// tangents are not unit then.
const MovingHit& move_hit(const GeometryView& geometry, const WorldInstance& instance,
                          std::span<const std::span<const M44f>> motions, uint32_t triangle, float time,
                          std::optional<MovingHit>& moving);

} // namespace kindling
