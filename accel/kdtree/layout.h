// Turns a binary tree into wide nodes and leaf blocks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/build.h"
#include "accel/kdtree/deforming/swept.h"
#include "accel/kdtree/node.h"

#include <vector>

namespace kindling::accel::kd {

// Throws std::bad_alloc if memory runs out, or if the tree exceeds what a ChildWord can number (32 GiB of leaves).
// `slice`: for a tree of moving planes, that of the shutter which it is for; else null.
[[nodiscard]] Tree lay_out(BinaryTree binary, std::vector<Geometry> geometries, const TimeSlice* slice = nullptr);

} // namespace kindling::accel::kd
