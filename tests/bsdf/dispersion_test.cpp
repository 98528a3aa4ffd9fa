// Tests of dispersion: prisms reproduce the Abbe number, and wavelength weights keep white neutral.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dispersion.h"
#include "renderer/bsdf/fresnel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kindling {
namespace {

constexpr float kF = 486.1f;
constexpr float kD = 587.6f;
constexpr float kC = 656.3f;

// Returns the deviation in radians of a ray in the xy plane through a prism of 60 degrees, in
// double precision.
double prism_deviation(double ior, double incidence) {
  const double apex = std::acos(0.5);
  const double inside = std::asin(std::sin(incidence) / ior);
  const double exit = std::asin(ior * std::sin(apex - inside));
  return incidence + exit - apex;
}

// From the minimum deviation: n = sin((apex + deviation) / 2) / sin(apex / 2).
double index_of_deviation(double ior) {
  const double apex = std::acos(0.5);
  const double deviation = prism_deviation(ior, std::asin(ior * std::sin(0.5 * apex)));
  return std::sin(0.5 * (apex + deviation)) / std::sin(0.5 * apex);
}

TEST(Dispersion, PrismReproducesAbbeNumber) {
  for (const float ior : {1.33f, 1.5168f, 1.7f}) {
    for (const float abbe : {20.0f, 35.0f, 64.2f}) {
      const float dispersion = 20.0f / abbe;
      const double n_f = index_of_deviation(static_cast<double>(dispersed_ior(ior, dispersion, kF)));
      const double n_d = index_of_deviation(static_cast<double>(dispersed_ior(ior, dispersion, kD)));
      const double n_c = index_of_deviation(static_cast<double>(dispersed_ior(ior, dispersion, kC)));
      EXPECT_NEAR(n_d, static_cast<double>(ior), 1e-6);
      // Indices are floats (6e-8 at most) and their difference is at least 5e-3.
      EXPECT_NEAR((n_d - 1.0) / (n_f - n_c), static_cast<double>(abbe), 1e-4 * static_cast<double>(abbe));
      EXPECT_GT(n_f, n_d);
    }
  }
}

TEST(Dispersion, MatchesExtensionFormula) {
  // n_d + (n_d - 1) / V (523655 / lambda^2 - 1.5168)
  for (const float nm : {400.0f, 450.0f, 520.0f, 600.0f, 680.0f}) {
    const float expected = 1.5f + 0.5f / 30.0f * (523655.0f / (nm * nm) - 1.5168f);
    EXPECT_NEAR(dispersed_ior(1.5f, 20.0f / 30.0f, nm), expected, 1e-5f); // the extension's constants are rounded
  }
  EXPECT_EQ(dispersed_ior(1.5f, 0.0f, 430.0f), 1.5f);
  EXPECT_EQ(dispersed_ior(1.02f, 80.0f, 680.0f), 1.0f); // clamped
}

TEST(Dispersion, MeanWeightIsWhite) {
  constexpr int kSteps = 1 << 18;
  double sum[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < kSteps; ++i) {
    const WavelengthSample s = sample_wavelength((static_cast<float>(i) + 0.5f) / kSteps);
    for (int c = 0; c < 3; ++c) {
      ASSERT_GE(s.weight[c], 0.0f);
      ASSERT_LE(s.weight[c], 4.0f);
      sum[c] += static_cast<double>(s.weight[c]);
    }
  }
  for (const double s : sum) EXPECT_NEAR(s / kSteps, 1.0, 1e-6);
}

TEST(Dispersion, WavelengthsDecreaseFromRedToViolet) {
  float previous = 1000.0f;
  for (int i = 0; i < 1000; ++i) {
    const float nm = sample_wavelength(static_cast<float>(i) / 1000.0f).nm;
    ASSERT_LT(nm, previous);
    ASSERT_GE(nm, 390.0f);
    ASSERT_LE(nm, 680.0f);
    previous = nm;
  }
  EXPECT_GE(sample_wavelength(kOneMinusEpsilon).nm, 390.0f);
  const auto at = [](float nm) {
    float low = 0.0f, high = 1.0f;
    for (int i = 0; i < 40; ++i) {
      const float middle = 0.5f * (low + high);
      (sample_wavelength(middle).nm > nm ? low : high) = middle;
    }
    return sample_wavelength(low).weight;
  };
  const Rgb red = at(650.0f), yellow = at(575.0f), green = at(535.0f), cyan = at(492.0f), blue = at(465.0f),
            violet = at(425.0f);
  EXPECT_GT(red.x, 10.0f * (red.y + red.z));
  EXPECT_NEAR(yellow.x / yellow.y, 1.0f, 0.3f);
  EXPECT_GT(green.y, 10.0f * (green.x + green.z));
  EXPECT_NEAR(cyan.y / cyan.z, 1.0f, 0.3f);
  EXPECT_GT(blue.z, 10.0f * (blue.x + blue.y));
  EXPECT_GT(violet.x, 0.05f * violet.z); // reddish blue
}

} // namespace
} // namespace kindling
