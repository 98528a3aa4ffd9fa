// From posed meshes to what is traced and shaded: vertices, instances, and the keys of what moves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"
#include "renderer/world/geometry.h"

#include <vector>

namespace kindling {

struct WorldParts;

struct PreparedGeometry {
  std::vector<Geometry> geometries; // one per accelerator mesh, baked ones first
  std::vector<int> nodes;           // of the baked ones: where each has its place from
  std::vector<WorldInstance> instances;
  std::vector<accel::MeshGroup> groups;
  std::vector<std::vector<M44f>> motions; // by accel::Instance::motion: the matrices of all keys
  Box3f bounds;                           // of the world, over the shutter; empty if there is nothing
};

// What is baked: moved to world space, a copy for each place that it stands in.
struct BakeChoice {
  std::vector<uint8_t> meshes; // by mesh: whether those of its instances are that neither deform nor move
  [[nodiscard]] bool is_baked(const PosedMesh& posed) const;
};
[[nodiscard]] BakeChoice choose_baked(const std::vector<Mesh>& meshes, const PosedScene& posed);

// Meshes that stand once or have few triangles, and deformed ones, are baked into one group in world space: their boxes may overlap as
// they like without a second level. Other meshes become one group each, and one instance for each node; what moves is never baked, and
// what deforms over the shutter has a group of its own.
// Consumes the meshes of both, those of the scene and its nodes as far as `parts` allow (null: all of them), whose geometries are taken where they are the
// same; WorldParts::keys are those of the result. Primitives without a material have the last one of the scene.
[[nodiscard]] PreparedGeometry prepare_geometry(Scene& scene, PosedScene& posed, WorldParts* parts = nullptr);

} // namespace kindling
