// What the builder moves around: references to triangles with bounds, and where the triangles come from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <cstdint>

namespace kindling::accel::kd {

// One mesh in a tree. Primitives of a tree are numbered through: primitive = first_primitive + triangle.
struct Geometry {
  TriangleMesh mesh;
  uint32_t first_primitive = 0;
  uint32_t instance = kNoId; // set in the world tree only
  uint32_t mesh_index = 0;   // into BuildInput::meshes

  [[nodiscard]] const Imath::V3f& vertex(uint32_t triangle, int corner) const {
    return mesh.positions[mesh.indices[3 * static_cast<size_t>(triangle) + static_cast<size_t>(corner)]];
  }
};

// The part of a triangle that lies in the voxel of a node: bounds conservative by less than two ulps. Not initialized, and laid
// out as eight lanes, of which the builder computes with all and ignores two.
struct alignas(32) Reference {
  Imath::V3f min;
  uint32_t geometry;
  Imath::V3f max;
  uint32_t triangle;
};
static_assert(sizeof(Reference) == 32);

} // namespace kindling::accel::kd
