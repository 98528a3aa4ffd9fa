// Lays out the nodes of deforming trees.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/deforming/moving_node.h"
#include "accel/kdtree/node_layout.h"

namespace kindling::accel::kd {

// See BoxLayout.
struct PlaneLayout {
  using Node = MovingNode;

  [[nodiscard]] static BinaryPlace root(const BinaryPlace& top) { return top; }
  static void place(const BinaryPlace& top, bool in_levels, MovingNode& node, PlacedChildren& children);
};

} // namespace kindling::accel::kd
