// The binary kd-tree between building and laying out: pointers, freed when the layouts are done.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

namespace kindling::accel::kd {

struct LeafReference {
  uint32_t geometry = 0;
  uint32_t triangle = 0;
};

// A null pointer to a node is an empty leaf.
struct BinaryNode {
  float position = 0.0f; // of an inner node
  int axis = -1;         // -1: leaf
  uint32_t count = 0;    // of a leaf
  std::unique_ptr<LeafReference[]> references;
  std::unique_ptr<BinaryNode> child[2]; // below and above the plane
  // Sum of areas of the wide nodes needed if this node may be cut up to 0, 1 or 2 levels further down; see layout.cpp.
  double cut_cost[3] = {0.0, 0.0, 0.0};

  [[nodiscard]] bool is_leaf() const { return axis < 0; }
};

} // namespace kindling::accel::kd
