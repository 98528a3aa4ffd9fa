// Gathers three levels of a binary tree of moving planes into a node.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/deforming/plane_layout.h"

#include "accel/kdtree/deforming/plane_cuts.h"

#include <bit>
#include <limits>

namespace kindling::accel::kd {
namespace {

// Takes the plane of `top`, which has the given index in its level, and then its children as far as
// chosen by joins_parent(), or all that fit.
void gather(const BinaryPlace& top, bool all, uint32_t level, uint32_t index, MovingNode& node, uint32_t& axes,
            PlacedChildren& children) {
  const uint32_t lane = (level == 0 ? kRootLane : level == 1 ? kSecondLane : kThirdLane) + index;
  node.planes[lane] = top.node->position;
  node.displacements[lane] = top.node->displacement();
  axes |= top.node->axis << (2 * lane);
  const uint32_t more = kWideLevels - 1 - level; // levels that still fit below
  for (uint32_t side = 0; side < 2; ++side) {
    const BinaryPlace child = {&top.node->children[side], top.depth + 1};
    const uint32_t child_index = 2 * index + side;
    if (child.node->is_inner() && more > 0 && (all || joins_parent(*child.node, more)))
      gather(child, all, level + 1, child_index, node, axes, children);
    else
      children[child_index << more] = child;
  }
}

} // namespace

void PlaneLayout::place(const BinaryPlace& top, bool in_levels, MovingNode& node, PlacedChildren& children) {
  node.planes.fill(std::numeric_limits<float>::infinity());
  node.displacements.fill(0.0f);
  uint32_t axes = 0;
  gather(top, in_levels, 0, 0, node, axes, children);
  node.planes[kAxesLane] = std::bit_cast<float>(kAxesExponent | axes);
}

} // namespace kindling::accel::kd
