// Statistical tests of vector draws: uniformity, independence, and cancellation by blue noise.
// SPDX-License-Identifier: Apache-2.0
#include "tests/sampling/chi_square.h"

#include "renderer/sampling/bounce_draws.h"
#include "renderer/sampling/draw_eight.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace kindling {
namespace {

constexpr SamplerKind kSamplers[] = {SamplerKind::blue_noise, SamplerKind::sobol, SamplerKind::independent};
constexpr size_t kLanes = 16; // two bounces

std::array<float, kLanes> two_bounces(const SampleAddress& address) {
  std::array<float, kLanes> lanes;
  for (uint32_t bounce = 0; bounce < 2; ++bounce) {
    const BounceDraws u = draw_bounce(address, 8 + 8 * bounce);
    const std::array<float, 8> values{u.choice.x, u.choice.y, u.direction.x, u.direction.y,
                                      u.light.x,  u.light.y,  u.roulette,    u.spare};
    std::copy(values.begin(), values.end(), lanes.begin() + 8 * bounce);
  }
  return lanes;
}

TEST(DrawEight, MatchesSingleDraws) {
  for (const SamplerKind kind : kSamplers) {
    const Sampler sampler(3, kind, 12);
    for (int round = 0; round < 100; ++round) {
      std::array<SampleAddress, 8> addresses;
      for (int i = 0; i < 8; ++i)
        addresses[static_cast<size_t>(i)] = sampler.address({round * 29 + i, round * 13}, static_cast<uint32_t>(round));
      const Imath::Vec2<Lanes> draws = draw_eight(addresses, static_cast<uint32_t>(round % 5));
      for (size_t i = 0; i < 8; ++i)
        EXPECT_EQ(V2f(draws.x[i], draws.y[i]), Sampler::sample_2d(addresses[i], static_cast<uint32_t>(round % 5)));
    }
  }
}

// Chi-square test of all pairs of lanes in 8 x 8 cells, with one sample of each of 8192 scramblings
// (seeds, and tiles for blue noise).
TEST(BounceDraws, LanesAreIndependent) {
  constexpr int kCells = 8;
  constexpr int kPoints = 8192;
  constexpr size_t kPairs = kLanes * (kLanes - 1) / 2;
  const double level = test::sidak_level(0.01, static_cast<int>(3 * kPairs));
  for (const SamplerKind kind : kSamplers) {
    std::vector<std::array<float, kLanes>> points;
    for (int i = 0; i < kPoints; ++i) {
      const Sampler sampler(static_cast<uint32_t>(i / 64), kind, 16);
      points.push_back(two_bounces(sampler.address({(i % 8) * 128 + 37, (i / 8 % 8) * 128 + 90}, 5)));
    }
    for (size_t a = 0; a < kLanes; ++a)
      for (size_t b = a + 1; b < kLanes; ++b) {
        std::array<double, kCells * kCells> counts{};
        for (const auto& p : points)
          counts[static_cast<size_t>(p[a] * kCells) * kCells + static_cast<size_t>(p[b] * kCells)] += 1.0;
        constexpr double kExpected = static_cast<double>(kPoints) / (kCells * kCells);
        double statistic = 0.0;
        for (const double c : counts) statistic += (c - kExpected) * (c - kExpected) / kExpected;
        EXPECT_GT(test::chi_square_tail(statistic, kCells * kCells - 1), level)
            << sampler_name(kind) << " lanes " << a << " " << b;
      }
  }
}

// Samples of neighboring pixels are uncorrelated; with blue noise they lie in opposite halves, so
// they are anticorrelated.
TEST(BounceDraws, NeighborsAreUncorrelatedOrAnticorrelated) {
  for (const SamplerKind kind : kSamplers) {
    double sum = 0.0;
    constexpr int kPairs = 20000;
    for (int i = 0; i < kPairs; ++i) {
      const Sampler sampler(static_cast<uint32_t>(i), kind, 1);
      const float left = draw_bounce(sampler.address({64, 40}, 0), 8).direction.x;
      const float right = draw_bounce(sampler.address({65, 40}, 0), 8).direction.x;
      sum += (static_cast<double>(left) - 0.5) * (static_cast<double>(right) - 0.5) * 12.0;
    }
    // Independent numbers have correlation 0, with standard error 1 / sqrt(pairs); numbers that are
    // independent within opposite halves have correlation -3/4.
    EXPECT_NEAR(sum / kPairs, kind == SamplerKind::blue_noise ? -0.75 : 0.0, 4.0 / std::sqrt(kPairs))
        << sampler_name(kind);
  }
}

// Mean squared errors of single pixels and of the mean of squares of 4 x 4 pixels, for an integrand
// of four dimensions.
struct Errors {
  double pixel = 0.0;
  double square = 0.0;
};
Errors errors_of(SamplerKind kind, uint32_t samples) {
  constexpr int kSide = 4;
  constexpr uint32_t kSeeds = 1000;
  const double exact = std::pow(1.0 - std::exp(-1.0), 4.0);
  Errors errors;
  for (uint32_t seed = 0; seed < kSeeds; ++seed) {
    const Sampler sampler(seed, kind, samples);
    double total = 0.0;
    for (int i = 0; i < kSide * kSide; ++i) {
      double sum = 0.0;
      for (uint32_t s = 0; s < samples; ++s) {
        const BounceDraws u = draw_bounce(sampler.address({4 + i % kSide, 8 + i / kSide}, s), 8);
        sum += std::exp(-static_cast<double>(u.choice.x + u.choice.y + u.direction.x + u.direction.y));
      }
      const double error = sum / samples - exact;
      errors.pixel += error * error / (kSide * kSide * kSeeds);
      total += error / (kSide * kSide);
    }
    errors.square += total * total / kSeeds;
  }
  return errors;
}

TEST(BounceDraws, BlueNoiseErrorsCancelAmongNeighbors) {
  for (const uint32_t samples : {1U, 4U, 16U}) {
    const Errors own = errors_of(SamplerKind::sobol, samples);
    const Errors blue = errors_of(SamplerKind::blue_noise, samples);
    // Single pixels are as good with either sampler. Both errors are means of 16,000 squares, of
    // which about a thousand are independent with blue noise; a squared normal has standard
    // deviation sqrt(2): 5 * sqrt(2 / 1000).
    EXPECT_NEAR(blue.pixel / own.pixel, 1.0, 0.22) << samples;
    EXPECT_NEAR(own.square / own.pixel, 1.0 / 16.0, 0.22 / 16.0) << samples;
    EXPECT_LT(blue.square, 0.3 * own.square) << samples;
  }
}

// For a smooth function of four dimensions, at a power of 4 samples, a set of four dimensions has
// much less error than padded pairs or independent draws.
TEST(BounceDraws, SetOfFourConvergesFasterThanPairs) {
  const auto error_of = [](uint32_t n, int method) {
    const double exact = std::pow(0.5, 4.0);
    double sum = 0.0;
    constexpr uint32_t kSeeds = 400;
    for (uint32_t seed = 0; seed < kSeeds; ++seed) {
      const Sampler sampler(seed, method == 2 ? SamplerKind::independent : SamplerKind::sobol, n);
      double estimate = 0.0;
      for (uint32_t i = 0; i < n; ++i) {
        const SampleAddress address = sampler.address({3, 4}, i);
        const BounceDraws u = draw_bounce(address, 8);
        const V2f other = method == 1 ? u.light : u.direction;
        estimate += static_cast<double>(u.choice.x * u.choice.y * other.x * other.y) / n;
      }
      sum += (estimate - exact) * (estimate - exact) / kSeeds;
    }
    return sum;
  };
  const double joint = error_of(256, 0);
  EXPECT_LT(joint * 3.0, error_of(256, 1));
  EXPECT_LT(joint * 10.0, error_of(256, 2));
}

} // namespace
} // namespace kindling
