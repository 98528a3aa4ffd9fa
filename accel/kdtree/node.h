// The memory layout of a finished tree: wide nodes, leaf blocks, and child references.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/aligned_array.h"
#include "accel/kdtree/leaf_block.h"
#include "accel/kdtree/reference.h"

#include <ImathBox.h>

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling::accel::kd {

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

// A finished tree over geometries in one space.
struct Tree {
  AlignedArray<WideNode> nodes;
  AlignedArray<PlaneDisplacements> displacements; // by node, in deforming trees; else empty
  AlignedArray<LeafUnit> leaves;                  // contiguous blocks: LeafBlock, or MovingBlock in deforming trees
  ChildWord root = kEmptyChild;
  Imath::Box3f bounds; // slightly enlarged; of a deforming tree, for all times of its slice
  // Slightly enlarged bounds that rays are clipped to; in a deforming tree those at the begin of
  // the slice, interpolated to those at its end.
  Imath::Box3f clip_bounds;
  Imath::Box3f clip_bounds_at_end;  // of a deforming tree
  float largest_extent = 0.0f;      // of a deforming tree: the largest range of a triangle's coordinates along an axis
  std::vector<Geometry> geometries; // sorted by first_primitive
  size_t triangle_count = 0, leaf_count = 0, reference_count = 0;

  [[nodiscard]] size_t memory_bytes() const {
    return sizeof(Tree) + nodes.size() * sizeof(WideNode) + displacements.size() * sizeof(PlaneDisplacements) +
           leaves.size() * sizeof(LeafUnit) + geometries.capacity() * sizeof(Geometry);
  }
  [[nodiscard]] bool deforms() const { return displacements.size() != 0; }
  // Returns the first block of a leaf in a static tree.
  [[nodiscard]] LeafBlock leaf_block(ChildWord leaf) const {
    assert((leaf & kLeafBit) != 0 && !deforms());
    return LeafBlock(leaves.data() + (leaf & ~kLeafBit));
  }
  [[nodiscard]] const Geometry& geometry_of(uint32_t primitive) const {
    assert(!geometries.empty());
    size_t first = 0, last = geometries.size();
    while (last - first > 1) {
      const size_t middle = (first + last) / 2;
      (geometries[middle].first_primitive <= primitive ? first : last) = middle;
    }
    return geometries[first];
  }
};

} // namespace kindling::accel::kd
