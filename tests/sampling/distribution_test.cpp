// Tests of tabulated distributions: probabilities, densities, samples, and invalid weights.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/alias_table.h"
#include "renderer/sampling/distribution_1d.h"
#include "renderer/sampling/distribution_2d.h"

#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace kindling {
namespace {

using test::Random;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Returns the p-value of Pearson's test of discrete counts; cells that expect fewer than 8 are
// pooled.
double counts_p_value(const std::vector<double>& probabilities, const std::vector<double>& counts, double samples) {
  double statistic = 0.0;
  double pooled_expected = 0.0;
  double pooled = 0.0;
  int cells = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    const double expected = probabilities[i] * samples;
    if (expected < 8.0) {
      pooled_expected += expected;
      pooled += counts[i];
      continue;
    }
    statistic += (counts[i] - expected) * (counts[i] - expected) / expected;
    ++cells;
  }
  if (pooled_expected > 8.0) {
    statistic += (pooled - pooled_expected) * (pooled - pooled_expected) / pooled_expected;
    ++cells;
  }
  return test::chi_square_tail(statistic, cells - 1);
}

std::vector<float> random_weights(size_t n, uint64_t seed, float zero_probability) {
  Random random(seed);
  std::vector<float> weights(n);
  for (float& w : weights) w = random.next_1d() < zero_probability ? 0.0f : std::exp(6.0f * random.next_1d());
  return weights;
}

TEST(Distribution1D, ProbabilitiesMatchWeights) {
  for (const size_t n : {size_t{1}, size_t{2}, size_t{7}, size_t{100}, size_t{4096}, size_t{100000}}) {
    const std::vector<float> weights = random_weights(n, n, n > 4 ? 0.3f : 0.0f);
    const Distribution1D d(weights);
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    EXPECT_NEAR(d.sum(), sum, 1e-6 * sum);
    double total = 0.0;
    for (uint32_t i = 0; i < d.size(); ++i) {
      const double p = static_cast<double>(d.probability(i));
      total += p;
      EXPECT_NEAR(p, static_cast<double>(weights[i]) / sum, 2.0 * 0x1p-24);
      EXPECT_EQ(p > 0.0, weights[i] > 0.0f);
    }
    EXPECT_EQ(total, 1.0); // exact, because probabilities are multiples of 2^-24
  }
}

// The inversion is exact: of all 2^24 draws, each cell receives exactly its probability.
TEST(Distribution1D, EnumeratedDrawsMatchProbabilitiesExactly) {
  std::vector<float> weights = random_weights(300, 5, 0.4f);
  weights[17] = 1e9f; // like the sun: the other weights are below a quantum
  weights.front() = weights.back() = 0.0f;
  const Distribution1D d(weights);
  std::vector<uint32_t> hits(weights.size(), 0);
  float previous = 0.0f;
  for (uint32_t i = 0; i < kCdfQuanta; ++i) {
    const Distribution1D::Sample s = d.sample(static_cast<float>(i) * 0x1p-24f);
    ++hits[s.index];
    ASSERT_GE(s.x, previous); // monotone
    ASSERT_TRUE(s.x >= 0.0f && s.x < 1.0f);
    previous = s.x;
  }
  for (uint32_t i = 0; i < d.size(); ++i) {
    EXPECT_EQ(static_cast<float>(hits[i]) * 0x1p-24f, d.probability(i)) << i;
    if (weights[i] > 0.0f) {
      EXPECT_GT(hits[i], 0U) << i;
    }
  }
}

TEST(Distribution1D, SamplePdfMatchesPdf) {
  const Distribution1D d(random_weights(64, 6, 0.2f));
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const Distribution1D::Sample s = d.sample(random.next_1d());
    ASSERT_EQ(s.pdf, d.pdf(s.x));
    ASSERT_EQ(s.index, static_cast<uint32_t>(s.x * 64.0f));
  }
  EXPECT_EQ(d.pdf(-0.1f), 0.0f);
  EXPECT_EQ(d.pdf(1.0f), 0.0f);
  EXPECT_EQ(d.pdf(kNan), 0.0f);
}

TEST(Distribution1D, InvalidWeightsCountAsZeroAndZeroWeightsAreUniform) {
  const std::vector<float> bad = {kNan, 1.0f, -3.0f, kInfinity, 1.0f, -kInfinity};
  const Distribution1D d(bad);
  EXPECT_EQ(d.probability(1), 0.5f);
  EXPECT_EQ(d.probability(4), 0.5f);
  EXPECT_EQ(d.sum(), 2.0);
  const Distribution1D none(std::vector<float>(3, 0.0f));
  EXPECT_EQ(none.sum(), 0.0);
  for (uint32_t i = 0; i < 3; ++i) EXPECT_NEAR(none.probability(i), 1.0f / 3.0f, 1e-7f);
  EXPECT_EQ(Distribution1D().sample(0.25f).x, 0.25f);
  EXPECT_EQ(Distribution1D().pdf(0.25f), 1.0f);
  const Distribution1D large(std::vector<float>{3e38f, 3e38f, 1e38f, 3e38f}); // the sum exceeds the range of floats
  EXPECT_NEAR(large.probability(2), 0.1f, 1e-6f);
  const Distribution1D small(std::vector<float>{1e-45f, 1e-45f});
  EXPECT_EQ(small.probability(0), 0.5f);
}

TEST(Distribution2D, ProbabilitiesMatchWeights) {
  constexpr uint32_t kWidth = 33;
  constexpr uint32_t kHeight = 17;
  std::vector<float> weights = random_weights(kWidth * kHeight, 9, 0.3f);
  for (uint32_t x = 0; x < kWidth; ++x) weights[5 * kWidth + x] = 0.0f; // a row of zeros
  const Distribution2D d(weights, kWidth, kHeight);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  EXPECT_NEAR(d.sum(), sum, 1e-6 * sum);
  double total = 0.0;
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      const float w = weights[y * kWidth + x];
      const V2f center((static_cast<float>(x) + 0.5f) / kWidth, (static_cast<float>(y) + 0.5f) / kHeight);
      total += static_cast<double>(d.probability(x, y));
      EXPECT_NEAR(static_cast<double>(d.probability(x, y)), static_cast<double>(w) / sum, 4.0 * 0x1p-24);
      EXPECT_EQ(d.pdf(center) > 0.0f, w > 0.0f);
      EXPECT_FLOAT_EQ(d.pdf(center), d.probability(x, y) * kWidth * kHeight);
    }
  }
  EXPECT_NEAR(total, 1.0, 1e-6);
  Random random(2);
  for (int i = 0; i < 100000; ++i) {
    const Distribution2D::Sample s = d.sample(random.next_2d());
    ASSERT_GT(weights[s.row * kWidth + s.column], 0.0f);
    ASSERT_FLOAT_EQ(s.pdf, d.probability(s.column, s.row) * kWidth * kHeight);
    ASSERT_TRUE(s.uv.x >= 0.0f && s.uv.x < 1.0f && s.uv.y >= 0.0f && s.uv.y < 1.0f);
    ASSERT_NEAR(s.uv.x * kWidth, static_cast<float>(s.column) + 0.5f, 0.50001f);
    ASSERT_NEAR(s.uv.y * kHeight, static_cast<float>(s.row) + 0.5f, 0.50001f);
  }
}

TEST(Distribution2D, InvalidWeightsCountAsZeroAndZeroWeightsAreUniform) {
  const Distribution2D one({{kNan, -1.0f, kInfinity, 2.0f}}, 2, 2);
  EXPECT_EQ(one.probability(1, 1), 1.0f);
  EXPECT_EQ(one.sum(), 2.0);
  const std::vector<float> zeros(12, 0.0f);
  const Distribution2D none(zeros, 4, 3);
  EXPECT_NEAR(none.pdf({0.3f, 0.9f}), 1.0f, 1e-6f);
  EXPECT_EQ(Distribution2D().pdf({0.3f, 0.9f}), 1.0f);
  EXPECT_EQ(Distribution2D().sample({0.3f, 0.9f}).uv, V2f(0.3f, 0.9f));
  EXPECT_EQ(one.pdf({0.3f, 1.0f}), 0.0f);
}

TEST(Distribution2D, TakesAboutFiveBytesPerCell) {
  const std::vector<float> weights(2048 * 1024, 1.0f);
  const Distribution2D d(weights, 2048, 1024);
  EXPECT_LT(static_cast<double>(d.memory_bytes()) / (2048.0 * 1024.0), 5.1);
}

TEST(DistributionStatistical, Distribution1DMatchesPdf) {
  const Distribution1D d(random_weights(100, 12, 0.2f));
  const auto draw = [&](Random& random) -> std::optional<std::array<double, 2>> {
    return std::array<double, 2>{d.sample(random.next_1d()).x, random.next_double()};
  };
  const auto result = test::chi_square_test(
      {0.0, 1.0, 0.0, 1.0}, draw, [&](double x, double) { return static_cast<double>(d.pdf(static_cast<float>(x))); },
      {.seed = 30});
  EXPECT_GT(result.p_value, test::sidak_level(0.01, 4)) << result.summary;
  EXPECT_NEAR(result.integral, 1.0, 2e-3);
}

// An environment with a sun, a horizon and a black ground. Cells are tested against their
// probabilities, positions within cells against the uniform distribution.
TEST(DistributionStatistical, Distribution2DMatchesProbabilities) {
  constexpr uint32_t kWidth = 64;
  constexpr uint32_t kHeight = 32;
  std::vector<float> weights = random_weights(kWidth * kHeight, 13, 0.0f);
  for (uint32_t i = 24 * kWidth; i < kWidth * kHeight; ++i) weights[i] = 0.0f;
  weights[7 * kWidth + 40] = 3e5f;
  const Distribution2D d(weights, kWidth, kHeight);
  constexpr int kSamples = 1000000;
  constexpr size_t kPlaces = 16;
  std::vector<double> probabilities(weights.size());
  std::vector<double> counts(weights.size(), 0.0);
  std::vector<double> places(kPlaces * kPlaces, 0.0);
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) probabilities[y * kWidth + x] = static_cast<double>(d.probability(x, y));
  }
  Random random(31);
  for (int i = 0; i < kSamples; ++i) {
    const Distribution2D::Sample s = d.sample(random.next_2d());
    const V2f cell(s.uv.x * kWidth, s.uv.y * kHeight);
    counts[s.row * kWidth + s.column] += 1.0;
    const auto px = static_cast<size_t>((cell.x - std::floor(cell.x)) * kPlaces);
    const auto py = static_cast<size_t>((cell.y - std::floor(cell.y)) * kPlaces);
    places[py * kPlaces + px] += 1.0;
  }
  const double level = test::sidak_level(0.01, 4);
  EXPECT_GT(counts_p_value(probabilities, counts, kSamples), level) << "seed 31";
  EXPECT_GT(counts_p_value(std::vector<double>(places.size(), 1.0 / (kPlaces * kPlaces)), places, kSamples), level)
      << "seed 31";
}

TEST(AliasTable, ProbabilitiesMatchWeights) {
  for (const size_t n : {size_t{1}, size_t{2}, size_t{3}, size_t{80}, size_t{80000}, size_t{1000003}}) {
    const std::vector<float> weights = random_weights(n, n, n > 4 ? 0.3f : 0.0f);
    const AliasTable table(weights);
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    EXPECT_NEAR(table.sum(), sum, 1e-9 * sum);
    double total = 0.0;
    for (uint32_t i = 0; i < table.size(); ++i) {
      const double p = static_cast<double>(table.probability(i));
      total += p;
      ASSERT_NEAR(p, static_cast<double>(weights[i]) / sum,
                  1e-6 * static_cast<double>(weights[i]) / sum + 1e-9 / static_cast<double>(n))
          << i;
      ASSERT_EQ(p > 0.0, weights[i] > 0.0f);
    }
    EXPECT_NEAR(total, 1.0, 1e-6);
  }
}

TEST(AliasTable, NeverChoosesZeroWeightsAtExtremeDraws) {
  std::vector<float> weights(1001, 0.0f);
  weights[500] = 1.0f;
  weights[3] = 1e-12f;
  const AliasTable table(weights);
  Random random(4);
  for (int i = 0; i < 1000000; ++i) {
    V2f u = random.next_2d();
    if (i % 4 == 0) u.x = i % 8 == 0 ? 0.0f : kOneMinusEpsilon;
    if (i % 3 == 0) u.y = i % 6 == 0 ? 0.0f : kOneMinusEpsilon;
    const AliasTable::Sample s = table.sample(u);
    ASSERT_GT(weights[s.index], 0.0f);
    ASSERT_EQ(s.probability, table.probability(s.index));
  }
}

TEST(AliasTable, InvalidWeightsCountAsZeroAndZeroWeightsAreUniform) {
  const AliasTable table(std::vector<float>{kNan, 1.0f, -3.0f, kInfinity, 3.0f});
  EXPECT_EQ(table.probability(0), 0.0f);
  EXPECT_NEAR(table.probability(1), 0.25f, 1e-7f);
  EXPECT_NEAR(table.probability(4), 0.75f, 1e-7f);
  const AliasTable none(std::vector<float>(5, 0.0f));
  for (uint32_t i = 0; i < 5; ++i) EXPECT_NEAR(none.probability(i), 0.2f, 1e-7f);
  EXPECT_TRUE(AliasTable().empty());
}

TEST(DistributionStatistical, AliasTableMatchesProbabilities) {
  const std::vector<float> weights = random_weights(5000, 15, 0.2f);
  const AliasTable table(weights);
  std::vector<double> counts(weights.size(), 0.0);
  std::vector<double> probabilities(weights.size());
  constexpr int kSamples = 2000000;
  Random random(32);
  for (int i = 0; i < kSamples; ++i) counts[table.sample(random.next_2d()).index] += 1.0;
  for (uint32_t i = 0; i < table.size(); ++i) probabilities[i] = static_cast<double>(table.probability(i));
  EXPECT_GT(counts_p_value(probabilities, counts, kSamples), test::sidak_level(0.01, 4)) << "seed 32";
}

} // namespace
} // namespace kindling
