// Selects persistent meshes by the animations of the scene.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/persistent_meshes.h"

#include <algorithm>
#include <cstdint>

namespace kindling {

size_t min_persistent_triangles(size_t fixed, uint64_t image_samples) {
  return std::max<size_t>(fixed, image_samples / kMaxSamplesPerPersistentTriangle);
}

void mark_persistent(const PlacedMeshes& placed, const SceneChanges& changes, size_t min_triangles,
                     std::vector<accel::TriangleMesh>& meshes) {
  if (!changes.any()) return;
  for (size_t m = 0; m < meshes.size(); ++m) {
    const Geometry& geometry = placed.geometries[m];
    if (m < placed.baked_nodes.size() &&
        (changes.nodes[static_cast<size_t>(placed.baked_nodes[m])] != 0 ||
         (geometry.material < changes.materials.size() && changes.materials[geometry.material] != 0)))
      continue;
    meshes[m].persistent_id = geometry.number;
  }

  const auto for_each_in_place = [&](const auto& f) {
    for (const WorldInstance& instance : placed.instances) {
      if (!instance.identity) continue;
      const accel::MeshGroup& group = placed.groups[instance.group];
      for (uint32_t m = group.first_mesh; m < group.first_mesh + group.mesh_count; ++m) f(meshes[m]);
    }
  };
  size_t persistent = 0, temporary = 0; // triangles
  for_each_in_place([&](const accel::TriangleMesh& mesh) {
    (mesh.persistent_id != 0 ? persistent : temporary) += mesh.triangle_count();
  });
  if (persistent >= min_triangles && persistent >= kMinPersistentFraction * temporary) return;
  for_each_in_place([](accel::TriangleMesh& mesh) { mesh.persistent_id = 0; });
}

} // namespace kindling
