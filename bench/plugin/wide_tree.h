// The compressed 8-wide BVH: nodes of 80 bytes with children in 8 bits a plane.
//
// After Ylitie, Karras, Laine, "Efficient incoherent ray traversal on GPUs through compressed wide
// BVHs", High Performance Graphics 2017. Departures, because this is for CPUs: a leaf is a block of
// up to four triangles for the four lanes of a register (there up to three triangles, one at a
// time), and a stack holds the children that remain to be visited.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/plugin/binary_tree.h"
#include "bench/plugin/geometry.h"

#include <cstring>
#include <vector>

namespace compressed_bvh {

constexpr size_t kWidth = 8;
constexpr size_t kLeafSize = 4;

// Plane q of an axis lies at origin + q 2^exponent. Children have slots by the octant in which they
// lie, so that the order of slots XOR the octant of a ray is roughly from near to far. Inner
// children are consecutive nodes by rising slot, leaves consecutive blocks.
struct WideNode {
  Vec origin{};
  int8_t exponent[3] = {};
  uint8_t inner = 0;        // a bit for each slot with an inner node
  uint32_t first_child = 0; // node of the lowest bit of `inner`
  uint32_t first_leaf = 0;  // block of the lowest bit of `leaf`
  uint8_t leaf = 0;         // a bit for each slot with a leaf; slots without either have empty boxes
  uint8_t unused[7] = {};
  uint8_t low[3][kWidth] = {};
  uint8_t high[3][kWidth] = {};
};
static_assert(sizeof(WideNode) == 80);

// The primitives of a leaf: [first, first + count) of `order`.
struct LeafRange {
  uint32_t first = 0;
  uint32_t count = 0;
};

struct WideTree {
  std::vector<WideNode> nodes; // the root is the first; empty without primitives
  std::vector<LeafRange> leaves;
  std::vector<uint32_t> order; // primitives, leaf by leaf
  Box box;
};

// Collapses a binary tree into one of least expected cost. `leaf_size`: the most primitives of a
// leaf, 1 to kLeafSize.
[[nodiscard]] WideTree widen(const std::vector<BinaryNode>& binary, size_t leaf_size);

// 2^exponent.
[[nodiscard]] inline float power_of_two(int exponent) {
  const auto bits = static_cast<uint32_t>(exponent + 127) << 23;
  float power;
  std::memcpy(&power, &bits, sizeof power);
  return power;
}

} // namespace compressed_bvh
