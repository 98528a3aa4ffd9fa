// The builder's data: meshes of a tree, and bounded references to their triangles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <cstdint>

namespace kindling::accel::kd {

// One mesh in a tree. Primitives are numbered over all meshes of a tree: primitive =
// first_primitive + triangle.
struct Geometry {
  TriangleMesh mesh;
  uint32_t first_primitive = 0;
  uint32_t instance = kNoId; // set in the world's trees only
  uint32_t mesh_index = 0;   // index into BuildInput::meshes

  [[nodiscard]] const Imath::V3f& vertex(uint32_t triangle, int corner) const {
    return mesh.positions[mesh.indices[3 * static_cast<size_t>(triangle) + static_cast<size_t>(corner)]];
  }
};

// The part of a triangle in the voxel of a node; bounds are conservative by less than two ulps. Not
// initialized. Laid out as eight lanes: the builder computes with all and ignores two.
struct alignas(32) Reference {
  Imath::V3f min;
  uint32_t geometry;
  Imath::V3f max;
  uint32_t triangle;
};
static_assert(sizeof(Reference) == 32);

} // namespace kindling::accel::kd
