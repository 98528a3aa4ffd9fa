// Curvature of a triangle by its shading normals.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/on_gpu.h"
#include "renderer/world/hit_records.h"
#include "renderer/world/world_view.h"

#include <array>
#include <optional>

namespace kindling {

// A triangle by whose normals a hit is shaded, in world space: one, or several in lanes. Deformed
// triangles have their first pose.
template <typename Real>
struct ShadedTriangleOf {
  std::array<Imath::Vec3<Real>, 3> corners, normals;
  Imath::Vec3<Real> barycentric; // of the hit
};

// Returns that of a hit; none without normals.
[[nodiscard]] inline std::optional<ShadedTriangleOf<float>> shaded_triangle(const WorldView& world,
                                                                            const accel::Hit& hit) {
  const GeometryView& geometry = world.geometries[hit.mesh];
  if (geometry.normal_offset == GeometryView::kAbsent) return std::nullopt;
  const WorldInstance& instance = world.instances[hit.instance];
  const HitRecords vertices(geometry, hit);
  const uint32_t* index = geometry.indices.data() + size_t{hit.triangle} * 3;
  ShadedTriangleOf<float> result{.barycentric = vertices.barycentric};
  for (size_t i = 0; i < 3; ++i) {
    const float* n = vertices.records[i] + geometry.normal_offset;
    result.corners[i] = geometry.positions[index[i]];
    result.normals[i] = V3f(n[0], n[1], n[2]);
    if (instance.identity) continue;
    result.corners[i] = transform_point(instance.object_to_world, result.corners[i]);
    result.normals[i] = transform_normal_direction(instance.object_to_world, result.normals[i]).normalized();
  }
  return result;
}

// Returns the root mean square, over all directions in the plane of the triangle, of the change of
// the interpolated normal, in radians per meter: the curvature of a sphere, .7 times that of a
// cylinder. Normal maps do not count.
template <typename Real>
[[nodiscard]] Real curvature_of(const ShadedTriangleOf<Real>& triangle) {
  using Vector = Imath::Vec3<Real>;
  const std::array<Vector, 3>&corners = triangle.corners, &normals = triangle.normals;
  const Vector edge1 = corners[1] - corners[0], edge2 = corners[2] - corners[0];
  const Real area2 = edge1.cross(edge2).length2(); // (twice the area)^2
  const Vector& b = triangle.barycentric;
  const Vector normal = normals[0] * b.x + normals[1] * b.y + normals[2] * b.z;
  const Real length2 = normal.length2();
  // The unit normal changes along the plane, at right angles to itself.
  const auto across = [&](const Vector& change) { return change - normal * Real(normal.dot(change) / length2); };
  const Vector change1 = across(normals[1] - normals[0]), change2 = across(normals[2] - normals[0]);
  // The squared Frobenius norm of the gradient that has these changes along the edges.
  const Real squared = change1.length2() * edge2.length2() - 2.0f * change1.dot(change2) * edge1.dot(edge2) +
                       change2.length2() * edge1.length2();
  const Real curvature2 = maximum(Real(0.5f * squared), Real(0.0f)) / (area2 * length2);
  return select(minimum(area2, length2) > 0.0f, square_root(curvature2), Real(0.0f));
}

// The same at a hit; 0 without normals.
[[nodiscard]] inline float curvature_at(const WorldView& world, const accel::Hit& hit) {
  const std::optional<ShadedTriangleOf<float>> triangle = shaded_triangle(world, hit);
  return triangle ? curvature_of(*triangle) : 0.0f;
}

#if !KINDLING_ON_GPU
// The same at hits of several lanes.
[[nodiscard]] inline Lanes curvature_at(const WorldView& world,
                                        const std::array<const accel::Hit*, Lanes::kCount>& hits) {
  std::array<LaneVectors, 3> corners, normals;
  LaneVectors barycentric;
  constexpr V3f kZero(0.0f);
  const ShadedTriangleOf<float> flat{{kZero, kZero, kZero}, {kZero, kZero, kZero}, kZero};
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    const ShadedTriangleOf<float> triangle = shaded_triangle(world, *hits[lane]).value_or(flat);
    for (size_t i = 0; i < 3; ++i) {
      corners[i].set(lane, triangle.corners[i]);
      normals[i].set(lane, triangle.normals[i]);
    }
    barycentric.set(lane, triangle.barycentric);
  }
  return curvature_of(ShadedTriangleOf<Lanes>{{corners[0].load(), corners[1].load(), corners[2].load()},
                                              {normals[0].load(), normals[1].load(), normals[2].load()},
                                              barycentric.load()});
}
#endif

} // namespace kindling
