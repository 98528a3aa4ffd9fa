// The memory layout of the nodes of deforming trees: moving planes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/child_word.h"

#include <array>
#include <cstdint>

namespace kindling::accel::kd {

// Three levels of the binary tree. Lanes of `planes`: 3 holds the root's, 0 and 1 those of its
// children below and above, 4 to 7 those of the next level in spatial order. Lane 2 holds the axes:
// the axis of lane i in bits 2i and 2i+1, under the exponent of 1.0 so that the lane is an ordinary
// number. Children are in spatial order. If a branch ends early, its child is in the first lane of
// its range and the planes below are +infinity on axis 0, which sends every ray there.
struct alignas(32) MovingNode {
  std::array<float, kWideLanes> planes; // at the begin of the tree's slice of the shutter
  std::array<ChildWord, kWideLanes> child;
  std::array<float, kWideLanes> displacements; // of the planes over the slice; 0 in lane 2
};
static_assert(sizeof(MovingNode) == 96);
inline constexpr uint32_t kAxesLane = 2, kRootLane = 3, kSecondLane = 0, kThirdLane = 4;
inline constexpr uint32_t kAxesExponent = 0x3f800000U;

} // namespace kindling::accel::kd
