// World bounds of a posed scene: exact per vertex, or per box if there are too many instances.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <span>

namespace kindling {
namespace {

constexpr uint64_t kMaxExactCorners = 1ULL << 27;
constexpr size_t kCornersPerTask = 1 << 16;

// Minimum and maximum are independent of order, so the parallel reduction is deterministic.
Box3f united(Box3f a, const Box3f& b) {
  a.extendBy(b);
  return a;
}

Box3f bounds_of(std::span<const V3f> positions, std::span<const uint32_t> indices, const M44f& to_world) {
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, indices.size(), kCornersPerTask), Box3f(),
      [&](const tbb::blocked_range<size_t>& range, Box3f box) {
        for (size_t i = range.begin(); i != range.end(); ++i) {
          const V3f p = transform_point(to_world, positions[indices[i]]);
          if (is_finite(p)) box.extendBy(p);
        }
        return box;
      },
      united);
}

Box3f bounds_of_corners(const Box3f& box, const M44f& to_world) {
  Box3f result;
  if (box.isEmpty()) return result;
  for (int i = 0; i < 8; ++i) {
    const V3f corner((i & 1) ? box.max.x : box.min.x, (i & 2) ? box.max.y : box.min.y, (i & 4) ? box.max.z : box.min.z);
    const V3f p = transform_point(to_world, corner);
    if (is_finite(p)) result.extendBy(p);
  }
  return result;
}

uint64_t corner_count(const Mesh& mesh) {
  uint64_t corners = 0;
  for (const Primitive& primitive : mesh.primitives) corners += primitive.indices.size();
  return corners;
}

} // namespace

Box3f world_bounds(const Scene& scene, const PosedScene& posed) {
  uint64_t corners = 0;
  for (const PosedMesh& mesh : posed.meshes) corners += corner_count(scene.meshes[static_cast<size_t>(mesh.mesh)]);
  const bool exact = corners <= kMaxExactCorners;

  std::vector<Box3f> mesh_boxes(exact ? 0 : scene.meshes.size());
  tbb::parallel_for(size_t{0}, mesh_boxes.size(), [&](size_t m) {
    for (const Primitive& primitive : scene.meshes[m].primitives) {
      mesh_boxes[m].extendBy(bounds_of(primitive.positions, primitive.indices, M44f()));
    }
  });

  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, posed.meshes.size()), Box3f(),
      [&](const tbb::blocked_range<size_t>& range, Box3f box) {
        for (size_t i = range.begin(); i != range.end(); ++i) {
          const PosedMesh& mesh = posed.meshes[i];
          const auto index = static_cast<size_t>(mesh.mesh);
          const std::vector<Primitive>& primitives = scene.meshes[index].primitives;
          const auto extend = [&](const std::vector<PosedMesh::Deformed>& deformed, const M44f& to_world) {
            if (!exact && deformed.empty()) {
              box.extendBy(bounds_of_corners(mesh_boxes[index], to_world));
              return;
            }
            for (size_t p = 0; p < primitives.size(); ++p) {
              const auto& positions = deformed.empty() ? primitives[p].positions : deformed[p].positions;
              box.extendBy(bounds_of(positions, primitives[p].indices, to_world));
            }
          };
          extend(mesh.deformed, mesh.mesh_to_world);
          for (const M44f& key : mesh.later_transforms) extend(mesh.deformed, key);
          for (const std::vector<PosedMesh::Deformed>& key : mesh.later_deformed) extend(key, mesh.mesh_to_world);
        }
        return box;
      },
      united);
}

} // namespace kindling
