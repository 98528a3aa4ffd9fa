// Repeated measurements: their median and spread, and ratios between two candidates of a race. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace kindling::app {

// The middle value, or the mean of the two in the middle; 0 if there are none.
[[nodiscard]] double median(std::span<const double> values);

// Percentile by linear interpolation between the nearest ranks; `fraction` in [0, 1]. 0 if there are no values.
[[nodiscard]] double percentile(std::span<const double> values, double fraction);

// What is quoted of repeated measurements.
struct Summary {
  double median = 0.0;
  double min = 0.0;
  double max = 0.0;

  // (max - min) / median in percent; 0 for a median of 0.
  [[nodiscard]] double spread_percent() const { return median > 0.0 ? (max - min) / median * 100.0 : 0.0; }
};
[[nodiscard]] Summary summarize(std::span<const double> values);

// Median of reference[i] / candidate[i]: above 1 where the candidate is faster. Repetitions that stand side by side were
// measured one after the other, so that what disturbs the machine for a while cancels. Sizes must be equal; pairs that are
// not positive are left out, and 0 is the answer if none is left.
[[nodiscard]] double speed_ratio(std::span<const double> reference_s, std::span<const double> candidate_s);

// Of positive values; others are left out. 0 if none is left.
[[nodiscard]] double geometric_mean(std::span<const double> values);

} // namespace kindling::app
