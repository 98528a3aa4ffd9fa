// Learned shares of directions that follow the environment, by region of the surfaces.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/owned_arrays.h"
#include "renderer/guiding/guide_record.h"
#include "renderer/guiding/region_node.h"

#include <cstddef>
#include <span>

namespace kindling {

// The walls of a glass are nearly parallel, so light from the environment keeps its direction
// through it. No light sample passes it, as it refracts; but a bounce towards a bright place of the
// environment finds that through the glass. A binary tree over space for each facing has the share
// of such bounces in each region. Immutable, thread-safe.
struct EnvironmentGuideView {
  static constexpr float kMaxShare = 0.5f;

  [[nodiscard]] bool empty() const { return nodes.empty(); }
  // Returns the share at a point, in [0, kMaxShare]; `normal` is unit. The guide must not be empty.
  [[nodiscard]] float find(const V3f& position, const V3f& normal) const {
    return shares[find_region(nodes, facing_of(normal), position)];
  }

  std::span<const RegionNode> nodes; // the roots of all facings come first
  std::span<const float> shares;     // by region
};

class EnvironmentGuide : public EnvironmentGuideView {
 public:
  EnvironmentGuide() = default;
  // Sorts `records`. Deterministic in the records and their order. Empty if no region has a share.
  explicit EnvironmentGuide(std::span<GuideRecord> records);
  // The same share everywhere, above 0 and at most kMaxShare.
  explicit EnvironmentGuide(float share);

  [[nodiscard]] size_t region_count() const { return region_count_; } // with a share above 0

 private:
  OwnedArrays arrays_;
  size_t region_count_ = 0;
};

// Returns the second moment of the records with a guide, relative to that without any. Below 1 is a
// gain. Of both, the brightest contributions are left out that are expected `rare` times among the
// paths of these records: without a guide, light that few pixels show is as good as missing.
[[nodiscard]] double second_moment(std::span<const GuideRecord> records, const EnvironmentGuideView& guide,
                                   double rare);

} // namespace kindling
