// Curvature of a triangle by its shading normals.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/world/hit_records.h"
#include "renderer/world/world_view.h"

#include <algorithm>
#include <cmath>

namespace kindling {

// Returns the root mean square, over all directions in the plane of a hit's triangle, of the change
// of the interpolated normal, in radians per meter: the curvature of a sphere, .7 times that of a
// cylinder. 0 without normals. Normal maps do not count; deformed triangles have their first pose.
[[nodiscard]] inline float curvature_at(const WorldView& world, const accel::Hit& hit) {
  const GeometryView& geometry = world.geometries[hit.mesh];
  if (geometry.normal_offset == GeometryView::kAbsent) return 0.0f;
  const WorldInstance& instance = world.instances[hit.instance];
  const HitRecords vertices(geometry, hit);
  const uint32_t* index = geometry.indices.data() + size_t{hit.triangle} * 3;
  std::array<V3f, 3> corners, normals;
  for (size_t i = 0; i < 3; ++i) {
    const float* n = vertices.records[i] + geometry.normal_offset;
    corners[i] = geometry.positions[index[i]];
    normals[i] = V3f(n[0], n[1], n[2]);
    if (instance.identity) continue;
    corners[i] = transform_point(instance.object_to_world, corners[i]);
    normals[i] = transform_normal_direction(instance.object_to_world, normals[i]).normalized();
  }
  const V3f edge1 = corners[1] - corners[0], edge2 = corners[2] - corners[0];
  const float area2 = edge1.cross(edge2).length2(); // (twice the area)^2
  const V3f& b = vertices.barycentric;
  const V3f normal = normals[0] * b.x + normals[1] * b.y + normals[2] * b.z;
  const float length2 = normal.length2();
  if (!(area2 > 0.0f && length2 > 0.0f)) return 0.0f;
  // The unit normal changes along the plane, at right angles to itself.
  const auto across = [&](const V3f& change) { return change - normal * (normal.dot(change) / length2); };
  const V3f change1 = across(normals[1] - normals[0]), change2 = across(normals[2] - normals[0]);
  // The squared Frobenius norm of the gradient that has these changes along the edges.
  const float squared = change1.length2() * edge2.length2() - 2.0f * change1.dot(change2) * edge1.dot(edge2) +
                        change2.length2() * edge1.length2();
  return std::sqrt(std::max(0.5f * squared, 0.0f) / (area2 * length2));
}

} // namespace kindling
