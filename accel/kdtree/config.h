// Builder parameters of the kd-tree: costs, thresholds and limits, by quality preset.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace kindling::accel::kd {

// Maximum depth of the binary tree for all presets; with kMaxWideDepth it sizes the traversal
// stack.
inline constexpr uint32_t kMaxDepth = 60;

// References that the estimate has to spare, so that small trees are never limited by it.
inline constexpr uint64_t kSpareReferences = 1U << 17;

struct Config {
  // Surface area heuristic. A step down costs traversal_cost; a leaf of n > 0 references costs
  // leaf_cost + triangle_cost * n. Fitted on five scenes: three steps down share a wide node, so a
  // step is cheap compared to a leaf, and a leaf tests up to sixteen triangles at once, so its size
  // hardly matters. Cheap steps cut off empty space with hardly any bonus.
  double traversal_cost = 1.0;
  double leaf_cost = 4.0;
  double triangle_cost = 0.3;
  // Fraction by which the triangle cost of a split that cuts off empty space is reduced.
  double empty_bonus = 0.05;
  // A leaf is divided at the plane off a flat wall (best_split_at_wall()) if that saves at least
  // wall_min_gain: in costs of a ray through the whole tree, times the number of triangles, since
  // memory counts per triangle. The step down to the two is cheaper than traversal_cost, because it
  // mostly takes a lane of a box node. wall_visits: visits to a wall over those that its area
  // predicts. One half of the rays would come from behind it, and of the others those that end
  // elsewhere do not reach it.
  double wall_step_cost = 0.5;
  double wall_visits = 0.25;
  double wall_min_gain = 30.0;
  // Maximum number of references for which every bound is tried as a plane; above it, bin borders
  // are.
  uint32_t exact_below = 32;
  // Maximum number of references for which all bounds near the best bin border are tried as well.
  uint32_t refine_below = 16384;
  // Maximum number of references of a subtree that is replaced by a leaf if no cheaper than one.
  uint32_t collapse_below = 512;
  // Maximum number of references in all leaves per triangle (plus a few for tiny meshes).
  double references_per_triangle = 8.0;
  // Number of references in all leaves per triangle that estimate_memory() counts on; a tree with
  // more (plus kSpareReferences) is built again with at most as many.
  double expected_references_per_triangle = 3.0;
  // Minimum number of references, exclusive, for which two children are built by different tasks.
  uint32_t parallel_above = 4096;

  [[nodiscard]] uint32_t max_depth(size_t triangles) const {
    // 10 + 1.6 log2(n) rounded down: a fifth of the binary exponent of n^8.
    const double n = std::max(1.0, static_cast<double>(triangles)), n2 = n * n, n4 = n2 * n2;
    const auto exponent = static_cast<uint32_t>(std::bit_cast<uint64_t>(n4 * n4) >> 52) - 1023;
    return std::min(kMaxDepth, 10 + exponent / 5);
  }
  [[nodiscard]] uint64_t max_references(size_t triangles) const {
    return 256 + static_cast<uint64_t>(references_per_triangle * static_cast<double>(triangles));
  }
  [[nodiscard]] uint64_t expected_references(size_t triangles) const {
    return kSpareReferences + static_cast<uint64_t>(expected_references_per_triangle * static_cast<double>(triangles));
  }
};

[[nodiscard]] inline Config config_for(Quality quality) {
  Config config;
  switch (quality) {
  case Quality::fast: // larger leaves, and nearly optimal planes
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
