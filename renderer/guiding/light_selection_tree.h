// Learned selection probabilities of the kinds of light by region of space.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/owned_arrays.h"
#include "renderer/guiding/guide_record.h"
#include "renderer/guiding/region_node.h"
#include "renderer/light/light_probabilities.h"

#include <cassert>
#include <cstdint>
#include <span>

namespace kindling {

// An unoccluded light sample of training.
struct LightRecord {
  V3f position{0.0f};
  uint8_t facing = 0; // facing_of() the normal with which the light was sampled
  LightKind kind = LightKind::tree;
  // Squared luminance contributed to the pixel, relative to the image there, times the selection
  // probability of the kind: its expected sum is that of the square if the kind were always
  // selected.
  float moment = 0.0f;
  // The probability with which the kind would have been selected without a guide; above 0.
  float unguided_probability = 1.0f;
};

// A binary tree over space for each facing. Immutable, thread-safe.
struct LightSelectionTreeView {
  using Node = RegionNode;

  [[nodiscard]] bool empty() const { return nodes.empty(); }
  // Returns the probabilities at a point; `normal` is unit. The tree must not be empty. The
  // reference is valid as long as the tree.
  [[nodiscard]] const LightProbabilities& find(const V3f& position, const V3f& normal) const {
    return find(position, facing_of(normal));
  }
  [[nodiscard]] const LightProbabilities& find(const V3f& position, uint32_t facing) const {
    assert(!empty() && facing < kFacings);
    return probabilities[find_region(nodes, facing, position)];
  }
  // Returns a search for the same. find_regions(nodes) ends it: `at` is the place in
  // `probabilities`.
  [[nodiscard]] static RegionSearch search(const V3f& position, const V3f& normal) {
    return {position, facing_of(normal)};
  }
  [[nodiscard]] size_t region_count() const { return probabilities.size(); }

  std::span<const Node> nodes; // the roots of all facings come first
  std::span<const LightProbabilities> probabilities;
};

class LightSelectionTree : public LightSelectionTreeView {
 public:
  LightSelectionTree() = default;
  // The same probabilities everywhere.
  explicit LightSelectionTree(const LightProbabilities& everywhere);
  // Sorts `records`. Deterministic in the records and their order.
  explicit LightSelectionTree(std::span<LightRecord> records);

 private:
  OwnedArrays arrays_;
};

// Returns the second moment of the records if kinds were selected with these probabilities,
// relative to that without a guide. Below 1 is a gain.
[[nodiscard]] double second_moment(std::span<const LightRecord> records, const LightSelectionTreeView& tree);

} // namespace kindling
