// The data that queries traverse: world trees, instance trees, and the hierarchies above them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/affine.h"
#include "accel/kdtree/deforming/slices.h"
#include "accel/kdtree/instance_level.h"
#include "accel/kdtree/node.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// The data that a ray needs of a transformed instance, in one cache line.
struct alignas(64) TransformedInstance {
  RayToObject to_object;
  uint32_t instance = 0;
  const Tree* tree = nullptr;
};
static_assert(sizeof(TransformedInstance) == 64);

// An instance that moves or deforms: the static meshes of a group, or its deforming ones.
struct MovingInstance {
  std::span<const Imath::M44f> keys;   // motion keys of its matrix; empty if it is placed by to_object
  std::span<const Imath::Box3f> boxes; // world bounds at each key, which interpolate to bounds at all times
  RayToObject to_object;
  bool in_place = false;      // an identity transform; to_object is not set
  const Tree* tree = nullptr; // set, unless `deforming` is
  const DeformingTrees* deforming = nullptr;
  uint32_t instance = 0;
};

struct Structure {
  HitFilter filter;
  Tree world_tree;     // static geometry under identity transforms; if the world is split, only persistent meshes
  Tree transient_tree; // if the world is split, its other meshes; else empty
  // Trees of static meshes by group; empty if no transformed or moving instance uses them.
  std::vector<Tree> group_trees;
  std::vector<TransformedInstance> transformed;
  InstanceLevel instance_level; // over `transformed`

  std::vector<DeformingTrees> deforming;         // by group; no slices if nothing deforms
  std::vector<std::vector<Imath::M44f>> motions; // matrix keys, as in BuildInput
  std::vector<Imath::Box3f> key_boxes;
  std::vector<MovingInstance> moving;
  InstanceLevel moving_level; // over `moving`, bounds of the whole shutter

  [[nodiscard]] bool is_split() const { return transient_tree.root != kEmptyChild; }
  [[nodiscard]] bool has_instances() const { return !transformed.empty() || !moving.empty(); }
};

} // namespace kindling::accel::kd
