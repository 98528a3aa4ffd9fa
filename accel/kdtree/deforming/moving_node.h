// The memory layout of the nodes of deforming trees: the boxes of their children, in motion.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/child_word.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace kindling::accel::kd {

// A BoxNode at the begin of the tree's slice of the shutter: at fraction f of the slice a face is
// at its position plus f times its displacement. The boxes overlap where the parts of triangles in
// neighboring cells do not move as the plane between them, so the order of children is approximate.
struct alignas(64) MovingNode {
  std::array<std::array<float, kWideLanes>, 3> low, high; // by axis
  std::array<ChildWord, kWideLanes> child;
  std::array<uint32_t, 8> order;
  std::array<std::array<float, kWideLanes>, 3> low_displacement, high_displacement;
};
static_assert(sizeof(MovingNode) == 448);
// Distance from a face to its displacement, in floats.
inline constexpr size_t kToDisplacement = offsetof(MovingNode, low_displacement) / sizeof(float);
static_assert(offsetof(MovingNode, high_displacement) - offsetof(MovingNode, high) == kToDisplacement * sizeof(float));

} // namespace kindling::accel::kd
