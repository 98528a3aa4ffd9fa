// Which meshes an accelerator is told to last (accel::TriangleMesh::lasting), so that what is built over them serves other frames too.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/world/geometry.h"
#include "renderer/world/scene_changes.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kindling {

// What lasts under identity transforms is traced apart from what does not if it has enough triangles, and so many times those of the
// rest: then a frame saves most of its build, and rays pay little (README.md).
inline constexpr size_t kMinPersistentFraction = 4;
// Enough are a fixed number, and one for so many samples of the image: a frame of many samples saves less by a build than its rays pay.
inline constexpr uint64_t kMaxSamplesPerPersistentTriangle = 16;
[[nodiscard]] size_t min_persistent_triangles(size_t fixed, uint64_t image_samples);

// Of a World whose scene was posed at a time.
struct PlacedMeshes {
  std::span<const Geometry> geometries; // by mesh
  std::span<const int> baked_nodes;     // for which the first of them have been baked
  std::span<const WorldInstance> instances;
  std::span<const accel::MeshGroup> groups;
};

// Sets TriangleMesh::lasting of `meshes` by the scene, the moment and the image alone, so that a frame of a sequence is traced as an image of that
// moment is. Baked meshes last that no animation moves, hides or deforms and whose material none changes; instanced ones always, as long
// as they do not deform. Those under identity transforms do not, if they do not pay by these numbers.
void mark_persistent(const PlacedMeshes& placed, const SceneChanges& changes, size_t min_triangles,
                     std::vector<accel::TriangleMesh>& meshes);

} // namespace kindling
