// Sorts measurements and takes their percentiles.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/measurement.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kindling::app {

double percentile(std::span<const double> values, double fraction) {
  if (values.empty()) return 0.0;
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double rank = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(rank);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (sorted[above] - sorted[below]) * (rank - static_cast<double>(below));
}

double median(std::span<const double> values) { return percentile(values, 0.5); }

Summary summarize(std::span<const double> values) {
  if (values.empty()) return {};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {median(values), *low, *high};
}

double speed_ratio(std::span<const double> reference_s, std::span<const double> candidate_s) {
  assert(reference_s.size() == candidate_s.size());
  std::vector<double> ratios;
  for (size_t i = 0; i < reference_s.size(); ++i)
    if (reference_s[i] > 0.0 && candidate_s[i] > 0.0) ratios.push_back(reference_s[i] / candidate_s[i]);
  return median(ratios);
}

double geometric_mean(std::span<const double> values) {
  double logarithms = 0.0;
  size_t count = 0;
  for (const double value : values) {
    if (!(value > 0.0)) continue;
    logarithms += std::log(value);
    ++count;
  }
  return count > 0 ? std::exp(logarithms / static_cast<double>(count)) : 0.0;
}

} // namespace kindling::app
