// The memory layout of a tree's nodes and child references.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace kindling::accel::kd {

// Maximum number of wide nodes from the root to a leaf, ensured by the layout.
inline constexpr uint32_t kMaxWideDepth = 32;

inline constexpr uint32_t kWideLanes = 8;  // children of a wide node
inline constexpr uint32_t kWideLevels = 3; // binary levels in a wide node

// A reference to a child. 0: empty. Top bit clear: index of a wide node (index 0 is unused). Top
// bit set: a leaf, with the index of the unit in Tree::leaves where its first block begins.
using ChildWord = uint32_t;
inline constexpr ChildWord kEmptyChild = 0;
inline constexpr ChildWord kLeafBit = 0x80000000U;

// Three levels of the binary tree in one cache line. Lanes of `planes`: 3 holds the root's, 0 and 1
// those of its children below and above, 4 to 7 those of the next level in spatial order. Lane 2
// holds the axes: the axis of lane i in bits 2i and 2i+1, under the exponent of 1.0 so that the
// lane is an ordinary number. Children are in spatial order. If a branch ends early, its child is
// in the first lane of its range and the planes below are +infinity on axis 0, which sends every
// ray there.
struct alignas(64) WideNode {
  std::array<float, kWideLanes> planes;
  std::array<ChildWord, kWideLanes> child;
};
static_assert(sizeof(WideNode) == 64);
inline constexpr uint32_t kAxesLane = 2, kRootLane = 3, kSecondLane = 0, kThirdLane = 4;
inline constexpr uint32_t kAxesExponent = 0x3f800000U;

// The displacement of each plane of a wide node over the tree's slice of the shutter; 0 in lane 2,
// that of the axes.
struct alignas(32) PlaneDisplacements {
  std::array<float, kWideLanes> lanes{};
};

} // namespace kindling::accel::kd
