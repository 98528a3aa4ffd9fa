// Nodes of trees that divide space into regions with something learned in each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cstdint>
#include <span>

namespace kindling {

struct RegionNode {
  static constexpr uint32_t kLeaf = 3;
  float split = 0.0f;
  uint32_t axis : 2 = kLeaf;
  uint32_t next : 30 = 0; // the first of two children, or the number of the region
};
static_assert(sizeof(RegionNode) == 8);

// Returns the number of the region that contains a point, below the node `at`.
[[nodiscard]] inline uint32_t find_region(std::span<const RegionNode> nodes, uint32_t at, const V3f& position) {
  while (nodes[at].axis != RegionNode::kLeaf)
    at = nodes[at].next + (position[static_cast<int>(nodes[at].axis)] >= nodes[at].split ? 1 : 0);
  return nodes[at].next;
}

} // namespace kindling
