// Persistent meshes: those whose acceleration structures later frames can reuse.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/world/geometry.h"
#include "renderer/world/scene_changes.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kindling {

// Persistent meshes under identity transforms are traced in a tree of their own if they have enough
// triangles, and this many times those of the rest: then a frame saves most of its build at a small
// cost per ray (README.md).
inline constexpr size_t kMinPersistentFraction = 4;
// The minimum is a fixed number, and one triangle for this many samples of the image: for many
// samples the rays cost more than the build saves.
inline constexpr uint64_t kMaxSamplesPerPersistentTriangle = 16;
[[nodiscard]] size_t min_persistent_triangles(size_t fixed, uint64_t image_samples);

// The meshes of a World whose scene was posed at a time.
struct PlacedMeshes {
  std::span<const Geometry> geometries; // by mesh
  std::span<const int> baked_nodes;     // nodes of the first meshes, which are baked
  std::span<const WorldInstance> instances;
  std::span<const accel::MeshGroup> groups;
};

// Marks the persistent ones of `meshes` as a function of the scene, the moment and the image alone,
// so that a frame of a sequence is traced like a single image of that moment. Baked meshes are
// persistent if no animation moves, hides or deforms them and none changes their material;
// instanced ones always, unless they deform. Those under identity transforms are only marked if
// these thresholds are met.
void mark_persistent(const PlacedMeshes& placed, const SceneChanges& changes, size_t min_triangles,
                     std::vector<accel::TriangleMesh>& meshes);

} // namespace kindling
