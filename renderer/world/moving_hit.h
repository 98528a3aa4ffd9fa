// Where the triangle of a hit is at the time of its ray, if it moves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/world/geometry.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace kindling {

// In place of what still geometry has in its arrays.
struct MovingHit {
  static constexpr size_t kMaxFloats = 3 + 4 + 4 + 2 * Geometry::kMaxTexcoordSets; // of a record

  WorldInstance instance;                              // as it is at that time
  std::array<V3f, 3> positions;                        // in the space of the instance
  std::array<std::array<float, kMaxFloats>, 3> copies; // of the records of a mesh that deforms
  std::array<const float*, 3> records;                 // these, or the geometry's own
  float error = 0.0f; // bound of what interpolation adds to the error of a position, meters
};

// `motions`: PreparedGeometry::motions. Between keys positions, normals, tangents and the entries of matrices are interpolated linearly;
// normals and tangents are not unit then. Fills `moving`, and returns what is in it.
const MovingHit& move_hit(const Geometry& geometry, const WorldInstance& instance,
                          std::span<const std::vector<M44f>> motions, uint32_t triangle, float time,
                          std::optional<MovingHit>& moving);

} // namespace kindling
