// Everything that a query walks through: the world's tree, and the trees of moved instances under a hierarchy of boxes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/affine.h"
#include "accel/kdtree/instance_level.h"
#include "accel/kdtree/node.h"

#include <cstdint>
#include <vector>

namespace kindling::accel::kd {

struct MovedInstance {
  RayToObject to_object;
  const Tree* tree = nullptr;
  uint32_t instance = 0;
};

struct Structure {
  HitFilter filter;
  Tree world_tree;               // instances with identity transform, in world space
  std::vector<Tree> group_trees; // by group; empty where no moved instance uses it
  std::vector<MovedInstance> moved;
  InstanceLevel instance_level; // over moved
};

} // namespace kindling::accel::kd
