// Fits Amdahl's law to measured speed-ups, and chooses numbers of threads. Pure functions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace kindling::app {

// T(n) = T(1) (s + (1 - s) / n): Amdahl, "Validity of the single processor approach to achieving
// large scale computing capabilities", AFIPS 1967.
struct AmdahlFit {
  double serial_share = 0.0; // s; below 0 if more threads are faster than ideal
  double residual = 0.0;     // root mean square of T(n) / fit - 1
  size_t counts = 0;         // numbers of threads above 1; the fit to a single one is exact

  [[nodiscard]] double speedup(double threads) const { return 1.0 / (serial_share + (1.0 - serial_share) / threads); }
};

// Fits T(n) / T(1) by least squares. `speedups` are pairs of threads and T(1) / T(n); those with
// one thread and those that are not positive are left out. Returns nothing if none is left.
[[nodiscard]] std::optional<AmdahlFit> fit_amdahl(std::span<const std::pair<int, double>> speedups);

// 1 to 4, then powers of two, and `max` (at least 1).
[[nodiscard]] std::vector<int> default_thread_counts(int max);

} // namespace kindling::app
