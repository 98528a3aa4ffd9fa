// Dynamic programming that decides which three binary levels share a node.
// The choice minimizes the summed area of all nodes, a measure of how many are visited: f(n) =
// A(n) + g(left, 2) + g(right, 2), where g(n, d) is the minimum sum for the subtree of n if d more
// levels fit into the current node: g(n, 0) = f(n), g(n, d) = min(f(n), g(left, d-1) +
// g(right, d-1)), and 0 for leaves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"

#include <algorithm>
#include <cassert>

namespace kindling::accel::kd {

// Sets area_cost of an inner node whose children have theirs. `area` is relative to that of the
// whole tree.
inline void choose_cuts(BinaryNode& node, double area) {
  assert(node.is_inner());
  const BinaryNode &below = node.children[0], &above = node.children[1];
  const float own = static_cast<float>(area) + (below.area_cost[2] + above.area_cost[2]);
  node.area_cost[0] = own;
  for (size_t d = 1; d < 3; ++d) node.area_cost[d] = std::min(own, below.area_cost[d - 1] + above.area_cost[d - 1]);
}

// Returns true if an inner node joins the node of its parent. `levels`: levels, 1 or 2, that
// still fit below the parent.
[[nodiscard]] inline bool joins_parent(const BinaryNode& node, uint32_t levels) {
  assert(node.is_inner() && (levels == 1 || levels == 2));
  return node.area_cost[levels] < node.area_cost[0];
}

} // namespace kindling::accel::kd
