// The memory layout of a finished tree: wide nodes, leaf blocks, and the words that point to them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/aligned_array.h"
#include "accel/kdtree/leaf_block.h"
#include "accel/kdtree/reference.h"

#include <ImathBox.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kindling::accel::kd {

inline constexpr uint32_t kWideLanes = 8;  // children of a wide node
inline constexpr uint32_t kWideLevels = 3; // binary levels in one

// What a child is. 0: empty. Top bit clear: number of a wide node (number 0 is not used). Top bit set: a leaf, and the number of
// the unit in Tree::leaves where its first block begins.
using ChildWord = uint32_t;
inline constexpr ChildWord kEmptyChild = 0;
inline constexpr ChildWord kLeafBit = 0x80000000U;

// Three levels of the binary tree in one cache line. Planes in lanes: 3 the root's, 0 and 1 those of its children below and
// above, 4 to 7 those of the next level in spatial order. Lane 2 holds the axes: the axis of lane i in bits 2i and 2i+1,
// under the exponent of 1.0 so that the lane is an ordinary number. Children are in spatial order; where a branch ends early its
// child stands in the first lane of its range and the planes below are +infinity on axis 0, which sends every ray there.
struct alignas(64) WideNode {
  std::array<float, kWideLanes> planes;
  std::array<ChildWord, kWideLanes> child;
};
static_assert(sizeof(WideNode) == 64);
inline constexpr uint32_t kAxesLane = 2, kRootLane = 3, kSecondLane = 0, kThirdLane = 4;
inline constexpr uint32_t kAxesExponent = 0x3f800000U;

// How far each plane of a wide node moves in the tree's slice of the shutter; lane 2, that of the axes, is 0.
struct alignas(32) PlaneDisplacements {
  std::array<float, kWideLanes> ways{};
};

// A finished tree over some geometries in one space.
struct Tree {
  AlignedArray<WideNode> nodes;
  AlignedArray<PlaneDisplacements> ways; // by node, of trees that deform; else none
  AlignedArray<LeafUnit> leaves;         // blocks, one behind the other: LeafBlock, or MovingBlock in trees that deform
  ChildWord root = kEmptyChild;
  Imath::Box3f bounds;              // exact; of a tree that deforms, at all times of its slice, and a little larger
  Imath::Box3f clip_bounds;         // a little larger: rays are cut to it, or, in a tree that deforms,
  Imath::Box3f clip_bounds_at_end;  // to what lies between the begin of the slice, above, and its end
  std::vector<Geometry> geometries; // by first_primitive
  size_t triangle_count = 0, leaf_count = 0, reference_count = 0;

  [[nodiscard]] size_t memory_bytes() const {
    return sizeof(Tree) + nodes.size() * sizeof(WideNode) + ways.size() * sizeof(PlaneDisplacements) +
           leaves.size() * sizeof(LeafUnit) + geometries.capacity() * sizeof(Geometry);
  }
  [[nodiscard]] bool deforms() const { return ways.size() != 0; }
  // The first block of a leaf, in a tree that does not deform.
  [[nodiscard]] LeafBlock leaf_block(ChildWord leaf) const { return LeafBlock(leaves.data() + (leaf & ~kLeafBit)); }
  [[nodiscard]] const Geometry& geometry_of(uint32_t primitive) const {
    size_t first = 0, last = geometries.size();
    while (last - first > 1) {
      const size_t middle = (first + last) / 2;
      (geometries[middle].first_primitive <= primitive ? first : last) = middle;
    }
    return geometries[first];
  }
};

} // namespace kindling::accel::kd
