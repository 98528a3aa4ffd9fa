// References from the nodes of a tree to its nodes and leaves, and limits of both kinds of nodes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling::accel::kd {

// Maximum number of nodes from the root to a leaf, ensured by the layout.
inline constexpr uint32_t kMaxWideDepth = 32;

inline constexpr uint32_t kWideLanes = 8;  // children of a node
inline constexpr uint32_t kWideLevels = 3; // binary levels that fit into every node

// A reference to a child. 0: empty. Top bit clear: index of a node (index 0 is unused). Top bit
// set: a leaf, with the index of the unit in Tree::leaves where its first block begins.
using ChildWord = uint32_t;
inline constexpr ChildWord kEmptyChild = 0;
inline constexpr ChildWord kLeafBit = 0x80000000U;

} // namespace kindling::accel::kd
