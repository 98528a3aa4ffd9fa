// A binary BVH by the surface area heuristic, with one primitive in each leaf.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/plugin/geometry.h"

#include <vector>

namespace compressed_bvh {

// Nodes of a subtree over k primitives are 2 k - 1 consecutive ones, in depth-first order: the left
// child of node i is i + 1. So threads build subtrees without a lock, and the tree does not depend
// on their number.
struct BinaryNode {
  Box box;
  uint32_t right = 0;     // 0: a leaf
  uint32_t primitive = 0; // of a leaf
};

// The longest path from the root, in nodes.
constexpr size_t kMaxBinaryDepth = 64 + 33;

// Builds over boxes that are not empty, by at most `threads` threads. Empty without boxes.
[[nodiscard]] std::vector<BinaryNode> build_binary_tree(const std::vector<Box>& boxes, unsigned threads);

} // namespace compressed_bvh
