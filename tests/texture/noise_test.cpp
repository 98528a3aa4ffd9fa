// Tests of noise functions against MaterialX's formulas, and of their range, mean and continuity.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace kindling {
namespace {

class Points {
 public:
  explicit Points(uint32_t seed) : random_(seed) {}
  V3f next(float range = 200.0f) {
    std::uniform_real_distribution<float> u(-range, range);
    const float x = u(random_), y = u(random_), z = u(random_);
    return {x, y, z};
  }

 private:
  std::mt19937 random_;
};

// The expected values were computed with the formulas of mx_noise.glsl in double precision by a
// separate program.
TEST(Noise, MatchesMaterialX) {
  EXPECT_EQ(noise::hash(3, -5), 327690931U);
  EXPECT_EQ(noise::hash(3, -5, 7), 1596859473U);
  EXPECT_EQ(noise::hash(3, -5, 7, 11), 2184426223U);
  constexpr float kTolerance = 2e-6f;
  EXPECT_NEAR(noise::perlin(V2f(0.3f, 0.7f)), 0.04074370f, kTolerance);
  EXPECT_NEAR(noise::perlin(V2f(12.125f, -7.625f)), -0.15271687f, kTolerance);
  EXPECT_NEAR(noise::perlin(V2f(-100.5f, 33.375f)), -0.23976135f, kTolerance);
  EXPECT_NEAR(noise::perlin(V3f(1.25f, -2.5f, 3.75f)), 0.04038083f, kTolerance);
  EXPECT_NEAR(noise::perlin(V3f(0.1f, 0.2f, 0.3f)), -0.23716525f, kTolerance);
  EXPECT_NEAR(noise::perlin(V3f(-17.3f, 40.6f, -3.9f)), -0.03404004f, 1e-5f);
  const V3f rgb2 = noise::perlin_rgb(V2f(12.125f, -7.625f)), rgb3 = noise::perlin_rgb(V3f(1.25f, -2.5f, 3.75f));
  const V3f expected2(-0.15271687f, -0.34991444f, 0.03494897f), expected3(0.04038083f, -0.13764048f, 0.27806614f);
  EXPECT_LT((rgb2 - expected2).length(), kTolerance);
  EXPECT_LT((rgb3 - expected3).length(), kTolerance);
  EXPECT_NEAR(noise::cell(V2f(3.5f, -1.5f)), 0.17077823f, kTolerance);
  EXPECT_NEAR(noise::cell(V3f(3.5f, -1.5f, 8.25f)), 0.29825513f, kTolerance);
  EXPECT_LT((noise::cell_rgb(V2f(0.0f, 0.0f)) - V3f(0.61106765f, 0.18582378f, 0.04130607f)).length(), kTolerance);
  EXPECT_LT((noise::cell_rgb(V3f(3.5f, -1.5f, 8.25f)) - V3f(0.64372917f, 0.65648009f, 0.79216362f)).length(),
            kTolerance);
}

TEST(Noise, PerlinIsZeroOnTheLatticeAndBounded) {
  Points points(1);
  double sum2 = 0.0, sum3 = 0.0, squares2 = 0.0, squares3 = 0.0;
  constexpr int kCount = 100000;
  float maximum = 0.0f;
  for (int k = 0; k < kCount; ++k) {
    const V3f p = points.next();
    const float a = noise::perlin(V2f(p.x, p.y)), b = noise::perlin(p);
    maximum = std::max({maximum, std::abs(a), std::abs(b)});
    sum2 += a, sum3 += b;
    squares2 += a * a, squares3 += b * b;
    if (k < 100) {
      const V3f lattice(std::floor(p.x), std::floor(p.y), std::floor(p.z));
      EXPECT_EQ(noise::perlin(lattice), 0.0f);
      EXPECT_EQ(noise::perlin(V2f(lattice.x, lattice.y)), 0.0f);
    }
  }
  EXPECT_LE(maximum, 1.0f);
  EXPECT_GT(maximum, 0.85f);
  // Distant points are independent; the tolerance is four standard errors.
  EXPECT_LT(std::abs(sum2 / kCount), 4.0 * std::sqrt(squares2 / kCount / kCount));
  EXPECT_LT(std::abs(sum3 / kCount), 4.0 * std::sqrt(squares3 / kCount / kCount));
}

TEST(Noise, PerlinIsSmooth) {
  Points points(2);
  for (int k = 0; k < 2000; ++k) {
    V3f p = points.next(20.0f);
    if (k % 2 == 0) p.x = std::floor(p.x); // across the borders of cells
    constexpr float kStep = 1e-3f;
    const float before = noise::perlin(p - V3f(kStep, 0, 0)), at = noise::perlin(p),
                after = noise::perlin(p + V3f(kStep, 0, 0));
    EXPECT_LT(std::abs(after - at), 4.0f * kStep);
    // The second derivative is bounded, so slopes agree on both sides.
    EXPECT_LT(std::abs(after - 2.0f * at + before), 40.0f * kStep * kStep + 1e-5f);
  }
}

TEST(Noise, AcceptsHugeAndNonFiniteCoordinates) {
  for (const float x : {std::numeric_limits<float>::infinity(), -1e30f, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_TRUE(std::isfinite(noise::perlin(V3f(x, 0.5f, 0.5f))));
    EXPECT_TRUE(std::isfinite(noise::cell(V2f(x, 0.5f))));
    V3f nearest;
    EXPECT_TRUE(std::isfinite(noise::worley(V3f(x, 0.5f, 0.5f), 1.0f, nearest).x));
  }
}

// Returns the sorted distances to all feature points of 3^n cells.
template <int kDimensions>
std::vector<float> distances_by_force(const V3f& p, float jitter) {
  std::vector<float> distances;
  const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y)),
            z = static_cast<int>(std::floor(p.z));
  for (int i = x - 1; i <= x + 1; ++i)
    for (int j = y - 1; j <= y + 1; ++j)
      for (int k = z - 1; k <= z + 1; ++k) {
        if (kDimensions == 2 && k != z) continue;
        V3f point(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
        const V3f in_cell = kDimensions == 2 ? noise::cell_rgb(V2f(point.x + 0.5f, point.y + 0.5f))
                                             : noise::cell_rgb(point + V3f(0.5f));
        point += (in_cell - V3f(0.5f)) * jitter + V3f(0.5f);
        V3f to = point - p;
        if (kDimensions == 2) to.z = 0.0f;
        distances.push_back(to.length());
      }
  std::sort(distances.begin(), distances.end());
  return distances;
}

TEST(Noise, WorleyFindsTheNearestPoints) {
  Points points(3);
  for (int k = 0; k < 3000; ++k) {
    const V3f p = points.next(50.0f);
    const float jitter = k % 3 == 0 ? 1.0f : 0.7f;
    V2f nearest2;
    V3f nearest3;
    const V3f d2 = noise::worley(V2f(p.x, p.y), jitter, nearest2), d3 = noise::worley(p, jitter, nearest3);
    const std::vector<float> e2 = distances_by_force<2>(p, jitter), e3 = distances_by_force<3>(p, jitter);
    for (size_t n = 0; n < 3; ++n) {
      EXPECT_NEAR(d2[static_cast<int>(n)], e2[n], 2e-5f);
      EXPECT_NEAR(d3[static_cast<int>(n)], e3[n], 2e-5f);
    }
    EXPECT_NEAR((nearest3 - p).length(), d3.x, 2e-5f);
    EXPECT_NEAR((nearest2 - V2f(p.x, p.y)).length(), d2.x, 2e-5f);
  }
}

TEST(Noise, CellsAreConstantAndUniform) {
  Points points(4);
  std::vector<int> counts(16, 0);
  constexpr int kCount = 32000;
  for (int k = 0; k < kCount; ++k) {
    const V3f p = points.next(5000.0f);
    const float value = noise::cell(p);
    EXPECT_EQ(value, noise::cell(V3f(std::floor(p.x) + 0.5f, std::floor(p.y) + 0.5f, std::floor(p.z) + 0.5f)));
    ++counts[static_cast<size_t>(std::min(value * 16.0f, 15.0f))];
  }
  double chi2 = 0.0;
  for (const int count : counts) chi2 += square(static_cast<float>(count) - kCount / 16.0f) / (kCount / 16.0f);
  EXPECT_LT(chi2, 37.7); // 15 degrees of freedom, 0.1 %
}

} // namespace
} // namespace kindling
