// The numbers that shape a kd-tree: costs, thresholds and limits of the builder, by quality preset.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kindling::accel::kd {

// Depth of the binary tree that no preset exceeds; the traversal stack is sized for it.
inline constexpr uint32_t kMaxDepth = 60;
// Wide nodes on the way from the root to a leaf: as many as the layout puts there.
inline constexpr uint32_t kMaxWideDepth = 32;

struct Config {
  // Surface area heuristic. A step down costs traversal_cost; a leaf of n > 0 references costs
  // leaf_cost + triangle_cost * n. Fitted on five scenes: three steps down share a wide node, so that a step costs little against
  // a leaf, and a leaf tests up to sixteen triangles at once, so that its size hardly matters. Cheap steps cut off empty space
  // with hardly any bonus.
  double traversal_cost = 1.0;
  double leaf_cost = 4.0;
  double triangle_cost = 0.3;
  // The triangles' cost of a split that cuts off empty space is reduced by this fraction.
  double empty_bonus = 0.05;
  // Up to so many references every bound is tried as a plane; above, the borders of bins,
  uint32_t exact_below = 96;
  // and then, up to so many references, all bounds near the best border.
  uint32_t refine_below = 16384;
  // Up to so many references a subtree that turned out no cheaper than a leaf becomes one.
  uint32_t collapse_below = 512;
  // Triangle references in all leaves, at most this many per triangle (and a few for tiny meshes).
  double references_per_triangle = 8.0;
  // Above so many references the two children are built by different tasks.
  uint32_t parallel_above = 4096;

  [[nodiscard]] uint32_t max_depth(size_t triangles) const {
    const double depth = 10.0 + 1.6 * std::log2(std::max<double>(1.0, static_cast<double>(triangles)));
    return std::min(kMaxDepth, static_cast<uint32_t>(depth));
  }
  [[nodiscard]] uint64_t max_references(size_t triangles) const {
    return 256 + static_cast<uint64_t>(references_per_triangle * static_cast<double>(triangles));
  }
};

[[nodiscard]] inline Config config_for(Quality quality) {
  Config config;
  switch (quality) {
  case Quality::fast: // larger leaves, and planes that are nearly as good
    config.leaf_cost = 1.5;
    config.triangle_cost = 0.1;
    config.exact_below = 32;
    config.refine_below = 512;
    config.collapse_below = 0;
    config.references_per_triangle = 4.0;
    break;
  case Quality::balanced: break;
  case Quality::best: config.exact_below = 16384; break;
  }
  return config;
}

} // namespace kindling::accel::kd
