// Everything that a query walks through: the world's tree, and the trees of moved instances under a hierarchy of boxes.
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

// All that a ray needs of it, in one cache line.
struct alignas(64) MovedInstance {
  RayToObject to_object;
  uint32_t instance = 0;
  const Tree* tree = nullptr;
};
static_assert(sizeof(MovedInstance) == 64);

// What a ray meets at its time: the still meshes of a group, or those that deform.
struct MovingInstance {
  std::span<const Imath::M44f> keys;   // of its matrix; none: it stands where to_object says
  std::span<const Imath::Box3f> boxes; // its bounds in the world at each key, between which they hold it too
  RayToObject to_object;
  bool in_place = false;      // the identity, to_object is not set
  const Tree* tree = nullptr; // or
  const DeformingTrees* deforming = nullptr;
  uint32_t instance = 0;
};

struct Structure {
  HitFilter filter;
  Tree world_tree;   // what stands still under identity transforms, in world space; where that is divided, what lasts
  Tree passing_tree; // where it is divided, the rest; else empty
  std::vector<Tree> group_trees; // of still meshes by group; empty where no moved or moving instance uses it
  std::vector<MovedInstance> moved;
  InstanceLevel instance_level; // over moved

  std::vector<DeformingTrees> deforming;         // by group; no slices where nothing deforms
  std::vector<std::vector<Imath::M44f>> motions; // keys, as BuildInput has them
  std::vector<Imath::Box3f> key_boxes;
  std::vector<MovingInstance> moving;
  InstanceLevel moving_level; // over moving, for the whole shutter

  [[nodiscard]] bool is_split() const { return passing_tree.root != kEmptyChild; }
};

} // namespace kindling::accel::kd
