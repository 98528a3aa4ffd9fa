// A mean and its standard error.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kindling::test {

// Accumulates a mean and its standard error.
struct Estimate {
  double sum = 0.0;
  double sum_of_squares = 0.0;
  size_t count = 0;

  void add(double value) {
    sum += value;
    sum_of_squares += value * value;
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / static_cast<double>(count); }
  [[nodiscard]] double standard_error() const {
    const auto n = static_cast<double>(count);
    return std::sqrt(std::max(sum_of_squares / n - mean() * mean(), 0.0) / n);
  }
};

} // namespace kindling::test
