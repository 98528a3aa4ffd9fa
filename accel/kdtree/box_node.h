// The memory layout of the nodes of static trees: the boxes of their children.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/child_word.h"

#include <array>
#include <cstdint>

namespace kindling::accel::kd {

// Up to eight children with their boxes, which lie in disjoint cells of the kd-tree. The boxes of
// lanes without a child are NaN, and no ray enters them.
//
// A ray meets the cells in an order that depends on the signs of its direction alone: if bit k of s
// says that component k is negative, child i of that order is in lane (order[s] >> 4 i) & 7.
struct alignas(64) BoxNode {
  std::array<std::array<float, kWideLanes>, 3> low, high; // by axis
  std::array<ChildWord, kWideLanes> child;
  std::array<uint32_t, 8> order;
};
static_assert(sizeof(BoxNode) == 256);

} // namespace kindling::accel::kd
