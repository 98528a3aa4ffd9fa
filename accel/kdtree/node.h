// A finished tree: nodes, leaf blocks, and the meshes that they refer to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/aligned_array.h"
#include "accel/kdtree/box_node.h"
#include "accel/kdtree/deforming/moving_node.h"
#include "accel/kdtree/geometry_table.h"
#include "accel/kdtree/leaf_block.h"

#include <ImathBox.h>

#include <cassert>
#include <cstddef>
#include <cstdint>

namespace kindling::accel::kd {

// A finished tree over geometries in one space.
struct Tree {
  AlignedArray<BoxNode> nodes;           // of a static tree, else empty; index 0 is unused in both arrays
  AlignedArray<MovingNode> moving_nodes; // of a deforming tree, else empty
  AlignedArray<LeafUnit> leaves;         // contiguous blocks: LeafBlock, or MovingBlock in deforming trees
  ChildWord root = kEmptyChild;
  Imath::Box3f bounds; // slightly enlarged; of a deforming tree, for all times of its slice
  // Slightly enlarged bounds that rays are clipped to; in a deforming tree those at the begin of
  // the slice, interpolated to those at its end.
  Imath::Box3f clip_bounds;
  Imath::Box3f clip_bounds_at_end; // of a deforming tree
  GeometryTable geometries;
  size_t triangle_count = 0, leaf_count = 0, reference_count = 0;

  [[nodiscard]] size_t memory_bytes() const {
    return sizeof(Tree) + nodes.size() * sizeof(BoxNode) + moving_nodes.size() * sizeof(MovingNode) +
           leaves.size() * sizeof(LeafUnit) + geometries.memory_bytes();
  }
  [[nodiscard]] size_t node_count() const {
    const size_t size = nodes.size() + moving_nodes.size();
    return size == 0 ? 0 : size - 1;
  }
  [[nodiscard]] bool deforms() const { return moving_nodes.size() != 0; }
  // Returns the first block of a leaf in a static tree.
  [[nodiscard]] LeafBlock leaf_block(ChildWord leaf) const {
    assert((leaf & kLeafBit) != 0 && !deforms());
    return LeafBlock(leaves.data() + (leaf & ~kLeafBit));
  }
  [[nodiscard]] const Geometry& geometry_of(uint32_t primitive) const { return geometries.of(primitive); }
};

} // namespace kindling::accel::kd
