// A shootout in a few figures: each kd-tree against the best that Embree offers, like with like.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/shootout_report.h"

#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// One figure: a ratio, against Embree's robust variants and against all of them.
struct EmbreeComparisonLine {
  std::string measure;
  std::optional<double> robust; // unset where the race has no such variant or kind of rays
  std::optional<double> any;
  double aim = 1.0;        // what the kd-tree is built for
  bool lower_wins = false; // of build time and memory; speeds are above 1 where the kd-tree is faster
};

struct EmbreeComparison {
  std::string contender; // variant's name
  std::vector<EmbreeComparisonLine> lines;
};

// One for each kd-tree of the race; none without an Embree. Speeds are geometric means over kinds of rays of the ratio between
// the fastest calls: of the kd-tree, and for each kind the fastest of Embree's calls and variants. "Single calls" compares only
// those. Ratios are medians over repetitions. A build or size is compared with the smallest of Embree's variants of that quality.
[[nodiscard]] std::vector<EmbreeComparison> compare_with_embree(const SceneResult& scene);
// Geometric means over the scenes.
[[nodiscard]] std::vector<EmbreeComparison> compare_with_embree(const ShootoutReport& report);

// "1.32x", "-".
[[nodiscard]] std::string format_ratio(const std::optional<double>& ratio);
// ">= 1.3x", "<= 4.0x".
[[nodiscard]] std::string format_aim(const EmbreeComparisonLine& line);
// For a terminal; empty for none. Ends with '\n'.
[[nodiscard]] std::string format_comparisons(const std::vector<EmbreeComparison>& comparisons,
                                             const std::string& of_what);

} // namespace kindling::app
