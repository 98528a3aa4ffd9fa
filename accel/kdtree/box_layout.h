// Lays out the nodes with the boxes of their children over the leaves of a binary tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/aligned_array.h"
#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/box_node.h"

namespace kindling::accel::kd {

struct BoxTree {
  AlignedArray<BoxNode> nodes; // index 0 is unused
  ChildWord root = kEmptyChild;
};

// The leaves of the binary tree must have their addresses (BinaryNode::leaf_unit()). Parallel; the
// result is the same for any number of threads.
[[nodiscard]] BoxTree lay_out_boxes(const BinaryNode& root);

} // namespace kindling::accel::kd
