// The builder's data: meshes of a tree, and bounded references to their triangles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

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

// The meshes of a tree that is built, and how far hits may lie beside their triangle along each
// axis (accel/triangle.h): cells refer to all triangles that are so near. Without margins by
// default.
struct BuildMeshes {
  std::span<const Geometry> geometries;
  float extent_margin = 0.0f;   // in largest extents of the triangle along an axis
  float rounding_margin = 0.0f; // in largest coordinates of the triangle: more than the rounding of the margins

  BuildMeshes(std::span<const Geometry> all) : geometries(all) {}
  BuildMeshes(const std::vector<Geometry>& all) : geometries(all) {}
  // Returns the margin of a triangle with this box, rounded up to a multiple of a quarter of a
  // power of two, so that most triangles at a corner have the same one and offer the same planes.
  // It depends on no other triangle: small ones have small margins, however large the scene is.
  [[nodiscard]] float margin_of(const Imath::V3f& min, const Imath::V3f& max) const {
    constexpr uint32_t kMantissa = 0x1fffffU;
    float extent = 0.0f, largest = 0.0f;
    for (int k = 0; k < 3; ++k) {
      extent = std::max(extent, max[k] - min[k]);
      largest = std::max(largest, std::max(-min[k], max[k]));
    }
    const float margin = extent_margin * extent + rounding_margin * largest;
    return std::bit_cast<float>((std::bit_cast<uint32_t>(margin) + kMantissa) & ~kMantissa);
  }
};

// The part of the surroundings of a triangle in the voxel of a node; bounds are conservative by
// less than two ulps. Not initialized. Laid out as eight lanes: the builder computes with all and
// ignores two.
struct alignas(32) Reference {
  Imath::V3f min;
  uint32_t geometry;
  Imath::V3f max;
  uint32_t triangle;
};
static_assert(sizeof(Reference) == 32);

} // namespace kindling::accel::kd
