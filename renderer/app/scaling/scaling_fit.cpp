// Fits Amdahl's law by least squares.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/scaling/scaling_fit.h"

#include <algorithm>
#include <cmath>

namespace kindling::app {

std::optional<AmdahlFit> fit_amdahl(std::span<const std::pair<int, double>> speedups) {
  // With x = 1 - 1/n and y = T(n)/T(1) - 1/n the law is y = s x.
  double xy = 0.0, xx = 0.0;
  AmdahlFit fit;
  for (const auto& [threads, speedup] : speedups) {
    if (threads <= 1 || !(speedup > 0.0)) continue;
    const double x = 1.0 - 1.0 / threads;
    xy += x * (1.0 / speedup - 1.0 / threads);
    xx += x * x;
    ++fit.counts;
  }
  if (fit.counts == 0) return std::nullopt;
  fit.serial_share = xy / xx;
  double squares = 0.0;
  for (const auto& [threads, speedup] : speedups) {
    if (threads <= 1 || !(speedup > 0.0)) continue;
    const double off = fit.speedup(threads) / speedup - 1.0;
    squares += off * off;
  }
  fit.residual = std::sqrt(squares / static_cast<double>(fit.counts));
  return fit;
}

std::vector<int> default_thread_counts(int max) {
  std::vector<int> counts;
  for (int n = 1; n <= max; n = n < 4 ? n + 1 : 2 * n) counts.push_back(n);
  if (counts.back() != max) counts.push_back(max);
  return counts;
}

} // namespace kindling::app
