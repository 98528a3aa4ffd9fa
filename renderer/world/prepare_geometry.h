// Prepares posed meshes for tracing and shading: vertices, instances and motion keys.
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
  std::vector<int> nodes;           // nodes of the baked ones
  std::vector<WorldInstance> instances;
  std::vector<int> instance_nodes; // kNone for that of the baked ones
  std::vector<accel::MeshGroup> groups;
  std::vector<std::vector<M44f>> motions; // by accel::Instance::motion: the matrices of all keys
  Box3f bounds;                           // of the world, over the shutter; empty without geometry
};

// The choice of baked meshes: moved to world space, with a copy for each placement.
struct BakeChoice {
  std::vector<uint8_t> meshes; // by mesh: 1 if instances that neither deform nor move are baked
  [[nodiscard]] bool is_baked(const PosedMesh& posed) const;
};
[[nodiscard]] BakeChoice choose_baked(const std::vector<Mesh>& meshes, const PosedScene& posed);

// Bakes meshes that are placed once or have few triangles, and deformed ones, into one group in
// world space, where boxes may overlap without a second level. Other meshes become one group each,
// and one instance per node. Moving meshes are never baked; meshes that deform over the shutter
// have a group of their own.
// Consumes the meshes of both arguments, and those of the scene and its nodes as far as `parts`
// allow (null: all of them). Equal geometries are taken from `parts`, whose WorldParts::keys are
// set to those of the result. Primitives without a material get the last one of the scene.
[[nodiscard]] PreparedGeometry prepare_geometry(Scene& scene, PosedScene& posed, WorldParts* parts = nullptr);

} // namespace kindling
