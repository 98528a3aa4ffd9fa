// Nodes of trees that divide space into regions with something learned in each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <algorithm>
#include <array>
#include <cstddef>
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

// A search for the region of a point: find_region() from the node `at`, which becomes the result.
struct RegionSearch {
  std::array<float, 4> position{}; // the fourth is compared in leaves, to no effect
  uint32_t at = 0;

  RegionSearch() = default;
  RegionSearch(const V3f& point, uint32_t root) : position{point.x, point.y, point.z, 0.0f}, at(root) {}
};

// Finds many regions, eight at a time: each search waits for one node after the other, so the waits
// of several overlap.
inline void find_regions(std::span<const RegionNode> nodes, std::span<RegionSearch> searches) {
  constexpr size_t kTogether = 8;
  for (size_t first = 0; first < searches.size(); first += kTogether) {
    const std::span<RegionSearch> together = searches.subspan(first, std::min(kTogether, searches.size() - first));
    for (bool searching = true; searching;) {
      searching = false;
      for (RegionSearch& search : together) {
        const RegionNode node = nodes[search.at];
        const uint32_t child = node.next + (search.position[node.axis] >= node.split ? 1 : 0);
        const bool inner = node.axis != RegionNode::kLeaf;
        search.at = inner ? child : search.at;
        searching |= inner;
      }
    }
    for (RegionSearch& search : together) search.at = nodes[search.at].next;
  }
}

} // namespace kindling
