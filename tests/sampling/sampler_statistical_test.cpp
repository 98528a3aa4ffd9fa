// Statistical tests of the sampler: uniformity, independence and convergence.
// SPDX-License-Identifier: Apache-2.0
#include "tests/sampling/chi_square.h"

#include "renderer/sampling/sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace kindling {
namespace {

using test::Random;

constexpr int kSide = 128; // pixels

// Returns the p-value of a chi-square test of points in 16 x 16 cells. Draws of different pixels
// are independent, so the test is exact.
double uniformity_p_value(const std::function<V2f(uint32_t key, uint32_t next_key)>& point, uint32_t seed) {
  constexpr int kCells = 16;
  std::vector<double> counts(kCells * kCells, 0.0);
  const Sampler sampler(seed);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const V2f p = point(sampler.pixel_key({x, y}), sampler.pixel_key({x + kSide, y}));
      counts[static_cast<size_t>(static_cast<int>(p.y * kCells) * kCells + static_cast<int>(p.x * kCells))] += 1.0;
    }
  }
  const double expected = static_cast<double>(kSide) * kSide / (kCells * kCells);
  double statistic = 0.0;
  for (const double c : counts) statistic += (c - expected) * (c - expected) / expected;
  return test::chi_square_tail(statistic, kCells * kCells - 1);
}

TEST(SamplerStatistical, OneSampleIndexIsUniformAcrossPixels) {
  constexpr int kChecks = 4 * 8;
  const double level = test::sidak_level(0.01, kChecks);
  for (uint32_t dimension = 0; dimension < 8; ++dimension) {
    for (const uint32_t index : {0U, 1U, 100U, 65535U}) {
      const double p = uniformity_p_value(
          [&](uint32_t key, uint32_t) { return Sampler::sample_2d(key, index, dimension); }, 100 + dimension);
      EXPECT_GT(p, level) << "dimension " << dimension << " index " << index;
    }
  }
}

TEST(SamplerStatistical, DimensionsAreIndependent) {
  constexpr int kChecks = 28 * 3;
  const double level = test::sidak_level(0.01, kChecks);
  for (uint32_t a = 0; a < 8; ++a) {
    for (uint32_t b = a + 1; b < 8; ++b) {
      const uint32_t index = 7 * a + b;
      const auto pair = [&](auto pick_a, auto pick_b) {
        return uniformity_p_value(
            [&](uint32_t key, uint32_t) {
              return V2f(pick_a(Sampler::sample_2d(key, index, a)), pick_b(Sampler::sample_2d(key, index, b)));
            },
            1000 + a * 8 + b);
      };
      const auto x = [](const V2f& v) { return v.x; };
      const auto y = [](const V2f& v) { return v.y; };
      EXPECT_GT(pair(x, x), level) << a << " " << b;
      EXPECT_GT(pair(x, y), level) << a << " " << b;
      EXPECT_GT(pair(y, y), level) << a << " " << b;
    }
  }
}

TEST(SamplerStatistical, PixelsAreIndependent) {
  const double level = test::sidak_level(0.01, 16);
  for (uint32_t dimension = 0; dimension < 16; ++dimension) {
    const double p = uniformity_p_value(
        [&](uint32_t key, uint32_t next) {
          return V2f(Sampler::sample_1d(key, 3, dimension), Sampler::sample_1d(next, 3, dimension));
        },
        2000 + dimension);
    EXPECT_GT(p, level) << dimension;
  }
}

// With Owen scrambling, two samples that a net places in opposite halves are independent within
// them, and so are the two coordinates. This test is the most sensitive to weak hashes; a plain
// digital shift fails it clearly.
TEST(SamplerStatistical, SamplesAreIndependentWithinTheirStrata) {
  constexpr uint32_t kPairs[] = {0U, 2U, 100U, 4094U};
  const double level = test::sidak_level(0.01, 4 * 4);
  const auto within = [](float v) { return 2.0f * v - std::floor(2.0f * v); };
  for (const uint32_t i : kPairs) {
    const auto p_value = [&](auto first, auto second) {
      return uniformity_p_value(
          [&](uint32_t key, uint32_t) {
            return V2f(within(first(Sampler::sample_2d(key, i, 2))), within(second(Sampler::sample_2d(key, i + 1, 2))));
          },
          3000 + i);
    };
    const auto x = [](const V2f& v) { return v.x; };
    const auto y = [](const V2f& v) { return v.y; };
    EXPECT_GT(p_value(x, x), level) << i;
    EXPECT_GT(p_value(y, y), level) << i;
    EXPECT_GT(p_value(x, y), level) << i;
    const double alone = uniformity_p_value(
        [&](uint32_t key, uint32_t) {
          return V2f(within(Sampler::sample_1d(key, i, 2)), within(Sampler::sample_1d(key, i + 1, 2)));
        },
        3000 + i);
    EXPECT_GT(alone, level) << i;
  }
}

// Within a pixel, draws of two dimensions are uncorrelated. The variance of the sum of products is
// known: samples 2i and 2i + 1 are in opposite halves in every dimension, which doubles the
// variance of the product of the two leading bits (9/16 of the total) relative to independent
// pairs: 25/16 in total.
TEST(SamplerStatistical, DimensionsOfOnePixelAreUncorrelated) {
  constexpr uint32_t kSamples = 64;
  for (uint32_t a = 0; a < 6; ++a) {
    for (uint32_t b = a + 1; b < 6; ++b) {
      double sum = 0.0;
      double squares = 0.0;
      constexpr int kPixels = 4096;
      for (int pixel = 0; pixel < kPixels; ++pixel) {
        const uint32_t key = Sampler(3).pixel_key({pixel, 5});
        double product = 0.0;
        for (uint32_t i = 0; i < kSamples; ++i) {
          product += (static_cast<double>(Sampler::sample_2d(key, i, a).x) - 0.5) *
                     (static_cast<double>(Sampler::sample_2d(key, i, b).y) - 0.5);
        }
        sum += product;
        squares += product * product;
      }
      const double mean = sum / kPixels;
      const double error = std::sqrt((squares / kPixels - mean * mean) / kPixels);
      EXPECT_LT(std::abs(mean / error), 4.0) << a << " " << b;
      // Four standard errors of a variance from 4096 pixels, each a sum of many terms: 4 sqrt(2 /
      // 4096) * 25/16.
      EXPECT_NEAR(squares / kPixels / (kSamples / 144.0), 25.0 / 16.0, 0.14) << a << " " << b;
    }
  }
}

// Returns the mean squared error of n-sample estimates over many pixels.
template <typename Integrand>
double mean_squared_error(uint32_t n, double exact, bool independent, const Integrand& integrand) {
  constexpr int kPixels = 512;
  Random random(n);
  double sum = 0.0;
  for (int pixel = 0; pixel < kPixels; ++pixel) {
    const uint32_t key = Sampler(11).pixel_key({pixel, 0});
    double estimate = 0.0;
    for (uint32_t i = 0; i < n; ++i) {
      const V2f u = independent ? random.next_2d() : Sampler::sample_2d(key, i, 0);
      const V2f v = independent ? random.next_2d() : Sampler::sample_2d(key, i, 1);
      estimate += integrand(u, v) / n;
    }
    sum += (estimate - exact) * (estimate - exact);
  }
  return sum / kPixels;
}

// For a smooth integrand of one draw, the variance of Owen scrambling converges as n^-3 (Owen
// 1997), that of independent draws as n^-1.
TEST(SamplerStatistical, SmoothIntegrandsConvergeFast) {
  const auto f = [](const V2f& u, const V2f&) {
    return std::exp(-static_cast<double>(u.x) - 2.0 * static_cast<double>(u.y));
  };
  const double exact = (1.0 - std::exp(-1.0)) * 0.5 * (1.0 - std::exp(-2.0));
  const double coarse = mean_squared_error(16, exact, false, f);
  const double fine = mean_squared_error(1024, exact, false, f);
  const double rate = std::log(coarse / fine) / std::log(64.0);
  EXPECT_GT(rate, 2.3);
  EXPECT_LT(fine * 1000.0, mean_squared_error(1024, exact, true, f));
}

// With two padded draws, a sum converges as fast as its terms, and a product at least as fast as
// with independent draws.
TEST(SamplerStatistical, PaddedDrawsKeepTheirConvergence) {
  const auto g = [](const V2f& u) {
    return static_cast<double>(u.x) * static_cast<double>(u.x) + static_cast<double>(u.y);
  };
  const double mean = 1.0 / 3.0 + 0.5;
  const auto sum = [&](const V2f& u, const V2f& v) { return g(u) + g(v); };
  EXPECT_LT(mean_squared_error(256, 2.0 * mean, false, sum) * 500.0, mean_squared_error(256, 2.0 * mean, true, sum));
  const auto product = [&](const V2f& u, const V2f& v) { return g(u) * g(v); };
  EXPECT_LT(mean_squared_error(256, mean * mean, false, product),
            0.6 * mean_squared_error(256, mean * mean, true, product));
}

} // namespace
} // namespace kindling
