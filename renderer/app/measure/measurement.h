// Statistics of repeated measurements: medians, spreads, ratios. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

namespace kindling::app {

// The middle value, or the mean of the two middle values; 0 if there are none.
[[nodiscard]] double median(std::span<const double> values);

// The percentile by linear interpolation between the nearest ranks; `fraction` in [0, 1]. 0 if
// there are no values.
[[nodiscard]] double percentile(std::span<const double> values, double fraction);

// The figures that reports quote of repeated measurements.
struct Summary {
  double median = 0.0;
  double min = 0.0;
  double max = 0.0;

  // (max - min) / median in percent; 0 for a median of 0.
  [[nodiscard]] double spread_percent() const { return median > 0.0 ? (max - min) / median * 100.0 : 0.0; }
};
[[nodiscard]] Summary summarize(std::span<const double> values);

// The median of reference[i] / candidate[i], above 1 if the candidate is faster. Times of the same
// index were measured one after the other, so that longer disturbances of the machine cancel. Sizes
// must be equal. Pairs that are not positive are left out; 0 if none is left.
[[nodiscard]] double speed_ratio(std::span<const double> reference_s, std::span<const double> candidate_s);

// The geometric mean of the positive values; 0 if there are none.
[[nodiscard]] double geometric_mean(std::span<const double> values);

} // namespace kindling::app
