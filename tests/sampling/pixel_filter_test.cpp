// Tests of pixel filters: names, moments, weights, and samples against their density.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/pixel_filter.h"

#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kindling {
namespace {

using test::Random;

constexpr FilterKind kKinds[] = {FilterKind::blackman_harris, FilterKind::gaussian, FilterKind::box,
                                 FilterKind::mitchell};

struct Moments {
  double total = 0.0;    // integral of f
  double absolute = 0.0; // integral of |f|
  double second = 0.0;   // integral of x^2 f
  double fourth = 0.0;
};

Moments moments(FilterKind kind, double width) {
  constexpr int kSteps = 200000;
  Moments m;
  for (int i = 0; i < kSteps; ++i) {
    const double x = width * ((i + 0.5) / kSteps - 0.5);
    const double f = filter_value(kind, width, x) * width / kSteps;
    m.total += f;
    m.absolute += std::abs(f);
    m.second += x * x * f;
    m.fourth += x * x * x * x * std::abs(f);
  }
  return m;
}

TEST(PixelFilter, NamesRoundTrip) {
  for (const FilterKind kind : kKinds) EXPECT_EQ(filter_from_name(filter_name(kind)), kind);
  EXPECT_EQ(filter_name(FilterKind::blackman_harris), "blackman-harris");
  EXPECT_EQ(filter_from_name("gauss"), std::nullopt);
  EXPECT_EQ(filter_from_name(""), std::nullopt);
}

TEST(PixelFilter, HasDefaultKindAndWidths) {
  const PixelFilter filter;
  EXPECT_EQ(filter.kind(), FilterKind::blackman_harris);
  EXPECT_EQ(filter.width(), 1.5f);
  EXPECT_EQ(PixelFilter({FilterKind::mitchell}).width(), 4.0f);
  EXPECT_EQ(PixelFilter({FilterKind::box, 2.0f}).width(), 2.0f);
}

TEST(PixelFilter, CurvesMatchKnownValues) {
  EXPECT_NEAR(filter_value(FilterKind::blackman_harris, 1.5, 0.0), 1.0, 1e-12);
  EXPECT_NEAR(filter_value(FilterKind::blackman_harris, 1.5, 0.75), 6e-5, 1e-9); // the window's pedestal
  EXPECT_NEAR(filter_value(FilterKind::gaussian, 6.0, 1.0), std::exp(-0.5), 1e-12);
  EXPECT_NEAR(filter_value(FilterKind::mitchell, 4.0, 0.0), 8.0 / 9.0, 1e-12);
  EXPECT_NEAR(filter_value(FilterKind::mitchell, 4.0, 1.0), 1.0 / 18.0, 1e-12);
  EXPECT_NEAR(filter_value(FilterKind::mitchell, 4.0, 2.0), 0.0, 1e-12);
  EXPECT_NEAR(moments(FilterKind::mitchell, 4.0).total, 1.0, 1e-8);
  EXPECT_EQ(filter_value(FilterKind::box, 1.0, 0.51), 0.0);
}

// Mean, variance and mean weight of stratified draws match the integrals of the filter. 1024^2
// strata leave an error below 1e-5 of the width; linear interpolation of the density between 129
// nodes has an error of up to (1 / 128)^2 / 8 times the curvature.
TEST(PixelFilter, SampleMomentsMatchFilter) {
  for (const FilterKind kind : kKinds) {
    for (const float width : {0.0f, 3.0f}) {
      const PixelFilter filter({kind, width});
      const double w = static_cast<double>(filter.width());
      const Moments exact = moments(kind, w);
      constexpr int kStrata = 1024;
      double weight = 0.0;
      double mean_x = 0.0;
      double second_x = 0.0;
      double second_y = 0.0;
      for (int i = 0; i < kStrata; ++i) {
        for (int j = 0; j < kStrata; ++j) {
          const PixelFilter::Sample s =
              filter.sample(V2f((static_cast<float>(i) + 0.5f) / kStrata, (static_cast<float>(j) + 0.5f) / kStrata));
          const double c = static_cast<double>(s.weight) / (kStrata * kStrata);
          weight += c;
          mean_x += c * static_cast<double>(s.offset.x);
          second_x += c * static_cast<double>(s.offset.x * s.offset.x);
          second_y += c * static_cast<double>(s.offset.y * s.offset.y);
          ASSERT_LE(std::abs(s.offset.x), 0.5f * filter.width());
          ASSERT_LE(std::abs(s.offset.y), 0.5f * filter.width());
        }
      }
      const double variance = exact.second / exact.total;
      // A stratum that contains Mitchell's change of sign has the weight of its middle.
      const double tolerance = kind == FilterKind::mitchell ? 4e-3 : 2e-4;
      EXPECT_NEAR(weight, 1.0, tolerance) << filter_name(kind);
      EXPECT_NEAR(mean_x, 0.0, 1e-5 * w) << filter_name(kind);
      EXPECT_NEAR(second_x / variance, 1.0, 3.0 * tolerance + 1e-3) << filter_name(kind);
      EXPECT_NEAR(second_y / variance, 1.0, 3.0 * tolerance + 1e-3) << filter_name(kind);
    }
  }
}

TEST(PixelFilter, WeightsHaveConstantMagnitude) {
  Random random(1);
  const PixelFilter harris;
  const PixelFilter mitchell({FilterKind::mitchell});
  const Moments m = moments(FilterKind::mitchell, 4.0);
  const double c = (m.absolute / m.total) * (m.absolute / m.total);
  double sum = 0.0;
  constexpr int kSamples = 1000000;
  for (int i = 0; i < kSamples; ++i) {
    const V2f u = random.next_2d();
    ASSERT_EQ(harris.sample(u).weight, 1.0f);
    const PixelFilter::Sample s = mitchell.sample(u);
    const double x = static_cast<double>(s.offset.x);
    const double y = static_cast<double>(s.offset.y);
    const double f = filter_value(FilterKind::mitchell, 4.0, x) * filter_value(FilterKind::mitchell, 4.0, y);
    if (std::abs(f) > 1e-3) {
      ASSERT_EQ(s.weight < 0.0f, f < 0.0);
    }
    ASSERT_NEAR(std::abs(static_cast<double>(s.weight)), c, 2e-3);
    sum += static_cast<double>(s.weight);
  }
  EXPECT_NEAR(sum / kSamples, 1.0, 5.0 * std::sqrt((c * c - 1.0) / kSamples) + 1e-6);
}

TEST(PixelFilterStatistical, SamplesMatchFilter) {
  const double level = test::sidak_level(0.01, 8);
  uint64_t seed = 40;
  for (const FilterKind kind : kKinds) {
    for (const float width : {0.0f, 2.5f}) {
      const PixelFilter filter({kind, width});
      const double r = 0.5 * static_cast<double>(filter.width());
      const Moments m = moments(kind, 2.0 * r);
      const auto draw = [&](Random& random) -> std::optional<std::array<double, 2>> {
        const PixelFilter::Sample s = filter.sample(random.next_2d());
        return std::array<double, 2>{s.offset.x, s.offset.y};
      };
      // The exact filter, not its table.
      const auto density = [&](double x, double y) {
        return std::abs(filter_value(kind, 2.0 * r, x) * filter_value(kind, 2.0 * r, y)) / (m.absolute * m.absolute);
      };
      const auto result = test::chi_square_test({-r, r, -r, r}, draw, density, {.seed = seed++});
      EXPECT_GT(result.p_value, level) << filter_name(kind) << ": " << result.summary;
      EXPECT_NEAR(result.integral, 1.0, 1e-3) << filter_name(kind);
      // The tabulated density agrees with the filter as well.
      for (int i = 0; i < 100; ++i) {
        const double x = r * (i + 0.3) / 100.0;
        EXPECT_NEAR(static_cast<double>(filter.pdf({static_cast<float>(x), static_cast<float>(-0.3 * x)})),
                    density(x, -0.3 * x), 2e-3 * density(0.0, 0.0));
      }
    }
  }
}

} // namespace
} // namespace kindling
