// Tests of the GGX albedo tables against independent quadratures.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/ggx_albedo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kindling {
namespace {

struct Reference {
  double e = 0.0;
  double b = 0.0;
};

// Integrates over half vectors instead of visible normals: tan(theta_h) = alpha sqrt(u / (1 - u))
// makes D cos(theta_h) uniform in u, and E = integral of D V 4 (wo . h) cos(theta_i) dh. The
// integrand is smooth except at the horizon; u is graded towards 1, where the facets of grazing
// views lie.
Reference integrate(double mu, double alpha) {
  constexpr int kRadial = 2000;
  constexpr int kAngular = 1000;
  const double a2 = alpha * alpha;
  const double sin_o = std::sqrt(1.0 - mu * mu);
  const double t_o = std::sqrt(a2 + (1.0 - a2) * mu * mu);
  Reference sum;
  for (int i = 0; i < kRadial; ++i) {
    const double v = (i + 0.5) / kRadial;
    const double rest = (1.0 - v) * (1.0 - v); // 1 - u
    const double u = 1.0 - rest;
    const double cos_h = std::sqrt(rest / (rest + a2 * u));
    const double sin_h = std::sqrt(1.0 - cos_h * cos_h);
    const double shift = std::fmod(i * 0.7548776662, 1.0);
    for (int j = 0; j < kAngular; ++j) {
      const double phi = std::numbers::pi * (j + shift) / kAngular;
      const double cos_d = sin_o * sin_h * std::cos(phi) + mu * cos_h;
      const double mu_i = 2.0 * cos_d * cos_h - mu;
      if (cos_d <= 0.0 || mu_i <= 0.0) continue;
      const double t_i = std::sqrt(a2 + (1.0 - a2) * mu_i * mu_i);
      const double visibility = 0.5 / (mu_i * t_o + mu * t_i);
      // D cos(theta_h) dh = du dphi / (2 pi); du = 2 (1 - v) dv.
      const double f = visibility * mu_i * 4.0 * cos_d / cos_h * 2.0 * (1.0 - v);
      sum.e += f;
      sum.b += f * std::pow(1.0 - cos_d, 5.0);
    }
  }
  const double n = 1.0 / (static_cast<double>(kRadial) * kAngular);
  return {sum.e * n, sum.b * n};
}

double roughness_of_row(uint32_t row) {
  return static_cast<double>(kMinRoughness) +
         (1.0 - static_cast<double>(kMinRoughness)) * row / (kGgxRoughnessNodes - 1.0);
}

double mu_of_column(uint32_t column, double alpha) {
  const double x = column / (kGgxMuNodes - 1.0);
  return std::min(2.0 * alpha * x * x / (1.0 + 2.0 * alpha - x * x), 1.0);
}

// Column 0 is the limit of mu = 0 and not such an integral; the interpolation test below covers it.
TEST(GgxTables, NodesMatchQuadrature) {
  for (uint32_t row = 0; row < kGgxRoughnessNodes; row += 5) {
    for (uint32_t column = 1; column < kGgxMuNodes; column += 6) {
      const double roughness = roughness_of_row(row);
      const double alpha = roughness * roughness;
      const double mu = mu_of_column(column, alpha);
      const Reference reference = integrate(mu, alpha);
      const GgxTableNode& node = kGgxTable[row * kGgxMuNodes + column];
      EXPECT_NEAR(static_cast<double>(node.e), reference.e, 2e-4) << "roughness " << roughness << " mu " << mu;
      EXPECT_NEAR(static_cast<double>(node.e) * (static_cast<double>(node.schlick_residual) + std::pow(1.0 - mu, 5.0)),
                  reference.b, 2e-4)
          << "roughness " << roughness << " mu " << mu;
    }
  }
}

// Verifies the interpolation error that ggx_albedo.h states.
TEST(GgxTables, InterpolationStaysWithinStatedError) {
  double worst = 0.0;
  double squares = 0.0;
  int count = 0;
  for (const float roughness : {0.011f, 0.03f, 0.06f, 0.13f, 0.27f, 0.42f, 0.55f, 0.71f, 0.84f, 0.97f}) {
    const GgxAlbedoTable table(roughness, roughness * roughness);
    for (const float mu : {0.002f, 0.01f, 0.03f, 0.1f, 0.22f, 0.37f, 0.55f, 0.74f, 0.9f, 0.99f}) {
      const Reference reference =
          integrate(static_cast<double>(mu), static_cast<double>(roughness) * static_cast<double>(roughness));
      const GgxAlbedo a = table(mu);
      const double error_e = std::abs(static_cast<double>(a.e) - reference.e);
      const double error_b = std::abs(static_cast<double>(a.b) - reference.b);
      worst = std::max({worst, error_e, error_b});
      squares += error_e * error_e + error_b * error_b;
      count += 2;
      EXPECT_LT(std::max(error_e, error_b), 2e-3) << "roughness " << roughness << " mu " << mu;
    }
  }
  EXPECT_LT(std::sqrt(squares / count), 5e-4);
  RecordProperty("worst", std::to_string(worst));
}

TEST(GgxTables, AveragesMatchInterpolatedTable) {
  constexpr int kSteps = 20000;
  for (const float roughness : {0.01f, 0.02f, 0.1f, 0.333f, 0.5f, 0.77f, 1.0f}) {
    const GgxAlbedoTable table(roughness, roughness * roughness);
    double e = 0.0;
    double b = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double root = (i + 0.5) / kSteps;
      const GgxAlbedo a = table(static_cast<float>(root * root));
      e += 4.0 * root * root * root * static_cast<double>(a.e) / kSteps;
      b += 4.0 * root * root * root * static_cast<double>(a.b) / kSteps;
    }
    const GgxAlbedo mean = ggx_average_albedo(roughness);
    EXPECT_NEAR(static_cast<double>(mean.e), e, 1e-4) << roughness;
    EXPECT_NEAR(static_cast<double>(mean.b), b, 1e-4) << roughness;
  }
}

TEST(GgxTables, AlbedosStayInRange) {
  for (int r = 0; r <= 300; ++r) {
    const float roughness = lerp(kMinRoughness, 1.0f, static_cast<float>(r) / 300.0f);
    const GgxAlbedoTable table(roughness, roughness * roughness);
    for (int m = 1; m <= 1000; ++m) {
      const GgxAlbedo a = table(square(static_cast<float>(m) / 1000.0f));
      ASSERT_TRUE(a.e >= 0.0f && a.e <= 1.0f && a.b >= 0.0f && a.b <= a.e) << roughness << " " << m;
    }
  }
}

} // namespace
} // namespace kindling
