// Summary of a shootout: each kd-tree against the best of Embree, like with like.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/shootout_report.h"

#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// One ratio to Embree: to its robust variants, and to all of them.
struct EmbreeComparisonLine {
  std::string measure;
  std::optional<double> robust; // unset without such a variant or kind of rays; 0: below the resolution of the clock
  std::optional<double> any;
  double aim = 1.0;        // the bound that the kd-tree is built to keep
  bool lower_wins = false; // true for build time and memory; speeds are above 1 if the kd-tree is faster
};

struct EmbreeComparison {
  std::string contender; // name of the variant
  std::vector<EmbreeComparisonLine> lines;
};

// One comparison for each kd-tree of the race; none without Embree. A speed is the geometric mean,
// over kinds of rays, of the ratio between the fastest call of the kd-tree and the fastest of all
// calls and variants of Embree; "single calls" only compares those. Ratios are medians over
// repetitions. Build time and memory are compared with the smallest of Embree's variants of that
// quality.
[[nodiscard]] std::vector<EmbreeComparison> compare_with_embree(const SceneResult& scene);
// Geometric means of these ratios over the scenes.
[[nodiscard]] std::vector<EmbreeComparison> compare_with_embree(const ShootoutReport& report);

// "1.32x", "0.0042x"; "-" if unset, "n/a" for 0.
[[nodiscard]] std::string format_ratio(const std::optional<double>& ratio);
// ">= 1.3x", "<= 4.0x".
[[nodiscard]] std::string format_aim(const EmbreeComparisonLine& line);
// Tables for a terminal; empty without comparisons. Ends with '\n'.
[[nodiscard]] std::string format_comparisons(const std::vector<EmbreeComparison>& comparisons,
                                             const std::string& of_what);

} // namespace kindling::app
