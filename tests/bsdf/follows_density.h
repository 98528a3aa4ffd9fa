// Expects that sampled directions have their density.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>

namespace kindling::test {

// draw(Random&) returns a unit direction, or none: absorbed. density(wi) is that of a direction;
// with the absorbed share its integral is 1. `level` is the significance of the chi-square test.
template <typename Draw, typename Density>
void expect_directions_follow(const Draw& draw, const Density& density, uint64_t seed, int samples, double level,
                              const std::string& what) {
  const ChiSquareOptions options = {.seed = seed,
                                    .pilot_samples = 12000,
                                    .samples = samples,
                                    .bins = 48,
                                    .min_extent = 2e-5,
                                    .may_be_absorbed = true};
  const auto result = chi_square_hemisphere(draw, density, options);
  EXPECT_GT(result.p_value, level) << what << ": " << result.summary;
  const double error = std::sqrt(result.absorbed * (1.0 - result.absorbed) / samples);
  EXPECT_NEAR(result.integral + result.absorbed, 1.0, 4.5 * error + 2e-3) << what;
}

} // namespace kindling::test
