// Lays out the nodes of static and of deforming trees.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/box_node.h"
#include "accel/kdtree/deforming/moving_node.h"
#include "accel/kdtree/node_layout.h"

namespace kindling::accel::kd {

// `Node`: BoxNode or MovingNode.
template <class AnyNode>
struct BoxLayout {
  using Node = AnyNode;

  // Passes over nodes with one child: their planes only cut off empty space, which boxes do as
  // well.
  [[nodiscard]] static BinaryPlace root(const BinaryPlace& top);

  // Sets all of a finished node but its children, and these as parts of the binary tree; `top` is a
  // root(), an inner node. `in_levels`: takes three levels of the binary tree, otherwise those that
  // cost least.
  static void place(const BinaryPlace& top, bool in_levels, Node& node, PlacedChildren& children);
};

} // namespace kindling::accel::kd
