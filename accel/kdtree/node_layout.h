// Parts of the binary tree that one finished node replaces, for the layout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/child_word.h"

#include <array>
#include <cstdint>

namespace kindling::accel::kd {

// A node of the binary tree, and its depth there.
struct BinaryPlace {
  BinaryNode* node = nullptr;
  uint32_t depth = 0;
};

// The children of a finished node by lane; `node` is null in lanes without one.
using PlacedChildren = std::array<BinaryPlace, kWideLanes>;

} // namespace kindling::accel::kd
