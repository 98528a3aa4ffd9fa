// Amdahl's law through measured speed-ups, and which numbers of threads are measured. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace kindling::app {

// T(n) = T(1) (s + (1 - s) / n): Amdahl, "Validity of the single processor approach to achieving large scale computing capabilities",
// AFIPS 1967.
struct AmdahlFit {
  double serial_share = 0.0; // s; below 0 where more threads are faster than ideal
  double residual = 0.0;     // root of the mean square of T(n) / fit - 1
  size_t counts = 0; // numbers of threads above 1. With one the fit is exact: it says no more than the speed-up does

  [[nodiscard]] double speedup(double threads) const { return 1.0 / (serial_share + (1.0 - serial_share) / threads); }
};

// Least squares of T(n) / T(1); `speedups`: pairs of threads and T(1) / T(n), of which those with one thread and those that are not
// positive are left out. Nothing if none is left.
[[nodiscard]] std::optional<AmdahlFit> fit_amdahl(std::span<const std::pair<int, double>> speedups);

// 1 to 4, then powers of two, and `most` (at least 1).
[[nodiscard]] std::vector<int> default_thread_counts(int most);

} // namespace kindling::app
