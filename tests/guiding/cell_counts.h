// Counts of sampled directions in cells, against those that their density predicts.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace kindling::test {

// Expects that the counts pass Pearson's chi-square test, one of `checks` at the level 0.001
// together. Returns the number of cells that it compares.
inline int expect_counts(const std::vector<double>& observed, const std::vector<double>& expected, int checks,
                         const std::string& where) {
  double statistic = 0.0;
  int cells = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    if (expected[i] < 8.0) {
      EXPECT_LT(observed[i], 40.0) << where << " " << i; // eleven standard deviations
      continue;
    }
    statistic += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
    ++cells;
  }
  EXPECT_GT(chi_square_tail(statistic, std::max(cells - 1, 1)), sidak_level(0.001, checks))
      << where << ": chi-square " << statistic << " in " << cells << " cells";
  return cells;
}

} // namespace kindling::test
