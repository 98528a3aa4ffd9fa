// Dynamic programming that decides which binary nodes become children of a box node.
// As in "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs" (Ylitie, Karras,
// Laine, HPG 2017), the choice minimizes the summed area of all box nodes, a measure of how many
// are visited: with A(n) the area of the box of n, a subtree that has up to k lanes of a box node
// costs c(n, 1) = A(n) + min over i of c(left, i) + c(right, 8 - i), if it is a node of its own,
// and c(n, k) = min(c(n, 1), min over i of c(left, i) + c(right, k - i)); leaves cost nothing.
// Nodes with one child pass on its costs, for boxes leave out empty space anyway.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/child_word.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

namespace kindling::accel::kd {

// The number of lanes that the child below the plane has, and the cost of both.
struct LaneShares {
  uint32_t below = 1;
  float cost = 0.0f;
};

// Divides 2 to 8 lanes among the children of a node, neither of which is empty.
[[nodiscard]] inline LaneShares share_lanes(const BinaryNode& node, uint32_t lanes) {
  assert(lanes >= 2 && lanes <= kWideLanes);
  const BinaryNode &below = node.children[0], &above = node.children[1];
  LaneShares best;
  for (uint32_t i = 1; i < lanes; ++i) {
    const float cost = below.area_cost[i - 1] + above.area_cost[lanes - i - 1];
    if (i == 1 || cost < best.cost) best = {i, cost};
  }
  return best;
}

// Sets area_cost of an inner node with this box, whose children have theirs. `inverse_area`: the
// reciprocal half area of the whole tree.
inline void choose_lanes(BinaryNode& node, const Imath::Box3f& box, double inverse_area) {
  assert(node.is_inner());
  const BinaryNode &below = node.children[0], &above = node.children[1];
  if (below.is_empty() || above.is_empty()) {
    node.area_cost = (below.is_empty() ? above : below).area_cost;
    return;
  }
  const Imath::V3f size = box.max - box.min;
  const double area = static_cast<double>(size.x) * size.y + static_cast<double>(size.y) * size.z +
                      static_cast<double>(size.z) * size.x;
  // The costs of share_lanes() for all numbers of lanes at once.
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::array<float, kWideLanes + 7> shifted; // those of the child above, after seven infinities
  shifted.fill(kInfinity);
  std::copy(above.area_cost.begin(), above.area_cost.end(), shifted.begin() + 7);
  std::array<float, kWideLanes> shared; // by the number of lanes, less 1
  shared.fill(kInfinity);
  for (uint32_t i = 1; i < kWideLanes; ++i)
    for (uint32_t k = 0; k < kWideLanes; ++k)
      shared[k] = std::min(shared[k], below.area_cost[i - 1] + shifted[7 + k - i]);
  const float own = static_cast<float>(area * inverse_area) + shared[kWideLanes - 1];
  for (uint32_t k = 0; k < kWideLanes - 1; ++k) node.area_cost[k] = std::min(own, shared[k]);
}

// The same, and sets the bounds of the node, in a static tree.
inline void choose_boxes(BinaryNode& node, double inverse_area) {
  node.bounds = node.children[0].bounds;
  node.bounds.extendBy(node.children[1].bounds);
  choose_lanes(node, node.bounds, inverse_area);
}

// Returns true if the children of an inner node take its place in the box node of its parent, where
// it has 1 to 7 lanes.
[[nodiscard]] inline bool is_opened(const BinaryNode& node, uint32_t lanes) {
  assert(node.is_inner() && lanes >= 1 && lanes < kWideLanes);
  return node.area_cost[lanes - 1] < node.area_cost[0];
}

} // namespace kindling::accel::kd
