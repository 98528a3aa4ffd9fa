// The cells of a binary tree, for comparison with the leaves of the finished one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"

#include <vector>

namespace kindling::accel::testing {

struct TreeCells {
  std::vector<Imath::Box3f> leaves; // below before above, as children are laid out
  std::vector<Imath::Box3f> empty;

  TreeCells(const kd::BinaryNode& node, const Imath::Box3f& cell) { add(node, cell); }

 private:
  void add(const kd::BinaryNode& node, const Imath::Box3f& cell) {
    if (!node.is_inner()) {
      (node.is_empty() ? empty : leaves).push_back(cell);
      return;
    }
    Imath::Box3f below = cell, above = cell;
    const auto axis = static_cast<int>(node.axis);
    below.max[axis] = above.min[axis] = node.position;
    add(node.children[0], below);
    add(node.children[1], above);
  }
};

} // namespace kindling::accel::testing
