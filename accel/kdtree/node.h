// A finished tree: wide nodes, leaf blocks, and the meshes that they refer to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/aligned_array.h"
#include "accel/kdtree/box_layout.h"
#include "accel/kdtree/geometry_table.h"
#include "accel/kdtree/leaf_block.h"
#include "accel/kdtree/wide_node.h"

#include <ImathBox.h>

#include <cassert>
#include <cstddef>
#include <cstdint>

namespace kindling::accel::kd {

// A finished tree over geometries in one space.
struct Tree {
  AlignedArray<WideNode> nodes;
  AlignedArray<PlaneDisplacements> displacements; // by node, in deforming trees; else empty
  AlignedArray<LeafUnit> leaves;                  // contiguous blocks: LeafBlock, or MovingBlock in deforming trees
  ChildWord root = kEmptyChild;
  BoxTree boxes;       // over the same leaves, in static trees; else empty
  Imath::Box3f bounds; // slightly enlarged; of a deforming tree, for all times of its slice
  // Slightly enlarged bounds that rays are clipped to; in a deforming tree those at the begin of
  // the slice, interpolated to those at its end.
  Imath::Box3f clip_bounds;
  Imath::Box3f clip_bounds_at_end; // of a deforming tree
  float largest_extent = 0.0f;     // of a deforming tree: the largest range of a triangle's coordinates along an axis
  GeometryTable geometries;
  size_t triangle_count = 0, leaf_count = 0, reference_count = 0;

  [[nodiscard]] size_t memory_bytes() const {
    return sizeof(Tree) + nodes.size() * sizeof(WideNode) + displacements.size() * sizeof(PlaneDisplacements) +
           boxes.nodes.size() * sizeof(BoxNode) + leaves.size() * sizeof(LeafUnit) + geometries.memory_bytes();
  }
  [[nodiscard]] bool deforms() const { return displacements.size() != 0; }
  // Returns the first block of a leaf in a static tree.
  [[nodiscard]] LeafBlock leaf_block(ChildWord leaf) const {
    assert((leaf & kLeafBit) != 0 && !deforms());
    return LeafBlock(leaves.data() + (leaf & ~kLeafBit));
  }
  [[nodiscard]] const Geometry& geometry_of(uint32_t primitive) const { return geometries.of(primitive); }
};

} // namespace kindling::accel::kd
