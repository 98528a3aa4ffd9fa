// Counts leaf sizes by walking all children of a tree.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/leaf_sizes.h"

#include "accel/kdtree/deforming/moving_block.h"

namespace kindling::accel::kd {
namespace {

template <class Block>
void count_blocks(const Tree& tree, std::vector<size_t>& sizes) {
  const auto visit = [&](ChildWord child) {
    if ((child & kLeafBit) == 0) return; // empty, or a node of the array
    size_t size = 0;
    for (const LeafUnit* unit = tree.leaves.data() + (child & ~kLeafBit);;) {
      const Block block(unit);
      size += block.triangle_count();
      if (block.is_last()) break;
      unit += block.units_to_next();
    }
    if (sizes.size() <= size) sizes.resize(size + 1, 0);
    ++sizes[size];
  };
  visit(tree.root);
  const auto visit_children = [&](const auto& nodes) {
    for (size_t n = 1; n < nodes.size(); ++n) // index 0 is unused
      for (const ChildWord child : nodes[n].child) visit(child);
  };
  visit_children(tree.nodes);
  visit_children(tree.moving_nodes);
}

} // namespace

void count_leaf_sizes(const Tree& tree, std::vector<size_t>& sizes) {
  tree.deforms() ? count_blocks<MovingBlock>(tree, sizes) : count_blocks<LeafBlock>(tree, sizes);
}

} // namespace kindling::accel::kd
