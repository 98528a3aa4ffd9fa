// Shares of the kinds of light by place: what of their light arrives is learned, not guessed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/guide_record.h"
#include "renderer/light/light_probabilities.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

// A light sample of training that was not occluded.
struct LightRecord {
  V3f position{0.0f};
  uint8_t facing = 0; // facing_of() the normal with which the light was sampled
  LightKind kind = LightKind::tree;
  // Square of the luminance that it brought to its pixel, relative to the image there, times the probability with which its kind
  // was chosen: the expectation of its sum is that of the square, had the kind been chosen for certain.
  float moment = 0.0f;
  float probability = 1.0f; // of the kind
};

// A binary tree over space for each facing. Immutable, thread-safe, without allocation after construction.
class ShareTree {
 public:
  ShareTree() = default;
  // Sorts `records` on the way. A function of the records and their order.
  explicit ShareTree(std::span<LightRecord> records);

  [[nodiscard]] bool empty() const { return nodes_.empty(); }
  // `normal`: unit. Not to be asked of an empty tree. The address lives as long as the tree.
  [[nodiscard]] const LightProbabilities& find(const V3f& position, const V3f& normal) const {
    return find(position, facing_of(normal));
  }
  [[nodiscard]] const LightProbabilities& find(const V3f& position, uint32_t facing) const {
    uint32_t at = facing;
    while (nodes_[at].axis != kLeaf)
      at = nodes_[at].next + (position[static_cast<int>(nodes_[at].axis)] >= nodes_[at].split ? 1 : 0);
    return shares_[nodes_[at].next];
  }
  [[nodiscard]] size_t region_count() const { return shares_.size(); }

 private:
  static constexpr uint32_t kLeaf = 3;
  struct Node {
    float split = 0.0f;
    uint32_t axis : 2 = kLeaf;
    uint32_t next : 30 = 0; // the first of two children, or the leaf's shares
  };
  static_assert(sizeof(Node) == 8);

  void build(uint32_t node, std::span<LightRecord> records, const LightProbabilities& around, uint32_t depth);

  std::vector<Node> nodes_; // the root of each facing first
  std::vector<LightProbabilities> shares_;
};

// Sum of the second moments of the records, had kinds been chosen by these shares; relative to the choices taken. Below 1 is
// a gain.
[[nodiscard]] double second_moment(std::span<const LightRecord> records, const ShareTree& shares);

} // namespace kindling
