// Tests of the dielectric albedo tables against an independent quadrature.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dielectric_albedo.h"

#include "tests/sampling/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kindling {
namespace {

using test::Random;

struct DielectricReference {
  double e = 0.0, p = 0.0, q = 0.0, reflected = 0.0;
};

// Integrates over all normals instead of the visible ones: tan(theta_h) = alpha sqrt(u / (1 - u))
// makes D cos(theta_h) uniform in u. The reflection is the integral of F G2 (wo . h) / (mu_o
// cos(theta_h)) over it, the refraction likewise. u is graded towards 1, where the facets of
// grazing views lie. Fresnel's equations are evaluated by angles.
DielectricReference integrate_dielectric(double mu, double alpha, double eta) {
  constexpr int kRadial = 300;
  constexpr int kAngular = 300;
  const double a2 = alpha * alpha;
  const double sin_o = std::sqrt(1.0 - mu * mu);
  const double lambda_o = 0.5 * (std::sqrt(1.0 + a2 * (1.0 - mu * mu) / (mu * mu)) - 1.0);
  const auto g2 = [&](double mu_i) {
    if (mu_i <= 0.0) return 0.0;
    return 1.0 / (1.0 + lambda_o + 0.5 * (std::sqrt(1.0 + a2 * (1.0 - mu_i * mu_i) / (mu_i * mu_i)) - 1.0));
  };
  DielectricReference sum;
  for (int i = 0; i < kRadial; ++i) {
    const double v = (i + 0.5) / kRadial;
    const double rest = (1.0 - v) * (1.0 - v); // 1 - u
    const double cos_h = std::sqrt(rest / (rest + a2 * (1.0 - rest)));
    const double sin_h = std::sqrt(1.0 - cos_h * cos_h);
    const double shift = std::fmod(i * 0.7548776662, 1.0);
    for (int j = 0; j < kAngular; ++j) {
      const double phi = std::numbers::pi * (j + shift) / kAngular;
      const double cos_d = sin_o * sin_h * std::cos(phi) + mu * cos_h;
      if (cos_d <= 0.0) continue;
      const double measure = cos_d / (mu * cos_h) * 2.0 * (1.0 - v);
      const double reflection = measure * g2(2.0 * cos_d * cos_h - mu);
      const double theta_o = std::acos(std::min(cos_d, 1.0));
      const double sine = std::sin(theta_o) / eta;
      if (sine >= 1.0) {
        sum.e += reflection;
        sum.reflected += reflection;
        continue;
      }
      const double theta_t = std::asin(sine);
      const double f = theta_o < 1e-4
                           ? std::pow((eta - 1.0) / (eta + 1.0), 2.0)
                           : 0.5 * (std::pow(std::sin(theta_o - theta_t) / std::sin(theta_o + theta_t), 2.0) +
                                    std::pow(std::tan(theta_o - theta_t) / std::tan(theta_o + theta_t), 2.0));
      const double refraction = measure * g2(mu / eta - cos_h * (cos_d / eta - std::cos(theta_t)));
      sum.e += f * reflection + (1.0 - f) * refraction;
      sum.p += reflection - refraction;
      sum.q += f * (reflection - refraction);
      sum.reflected += f * reflection;
    }
  }
  const double n = 1.0 / (static_cast<double>(kRadial) * kAngular);
  return {sum.e * n, sum.p * n, sum.q * n, sum.reflected / sum.e};
}

DielectricAlbedo look_up(double mu, double roughness, double eta) {
  const auto r = static_cast<float>(roughness);
  return dielectric_albedo(static_cast<float>(mu), r, r * r, static_cast<float>(eta));
}

TEST(DielectricTables, NodesMatchQuadrature) {
  const auto check = [](const DielectricTableShape& shape, bool outside) {
    for (uint32_t k = 0; k < shape.eta; k += 3) {
      for (uint32_t j = 1; j < shape.roughness; j += 5) {
        for (uint32_t i = 3; i < shape.mu; i += 8) {
          const double critical = 0.14106736 + (0.91651514 - 0.14106736) * k / (static_cast<double>(shape.eta) - 1.0);
          const double smaller = std::sqrt(1.0 - critical * critical);
          const double eta = outside ? 1.0 / smaller : smaller;
          const double roughness = 0.03 + 0.97 * j / (static_cast<double>(shape.roughness) - 1.0);
          const double alpha = roughness * roughness;
          const double x = i / (static_cast<double>(shape.mu) - 1.0);
          const double mu = std::min(2.0 * alpha * x * x / (1.0 + 2.0 * alpha - x * x), 1.0);
          const DielectricReference r = integrate_dielectric(mu, alpha, eta);
          const DielectricAlbedo a = look_up(mu, roughness, eta);
          ASSERT_NEAR(static_cast<double>(a.e), r.e, 1.5e-3) << mu << " " << roughness << " " << eta;
          ASSERT_NEAR(static_cast<double>(a.p), r.p, 1.5e-3) << mu << " " << roughness << " " << eta;
          ASSERT_NEAR(static_cast<double>(a.q), r.q, 1.5e-3) << mu << " " << roughness << " " << eta;
          ASSERT_NEAR(static_cast<double>(a.reflected), r.reflected, 5e-3) << mu << " " << roughness << " " << eta;
        }
      }
    }
  };
  check(kDielectricOutside, true);
  check(kDielectricInside, false);
}

// Verifies the interpolation error that the README states. The relative error counts, since e is a
// divisor.
TEST(DielectricTables, InterpolationStaysWithinStatedError) {
  for (const bool outside : {true, false}) {
    Random random(outside ? 1 : 2);
    double worst = 0.0, squares_e = 0.0, squares_reflected = 0.0;
    constexpr int kPoints = 150;
    for (int n = 0; n < kPoints; ++n) {
      const double mu = 0.02 + 0.98 * random.next_double();
      const double roughness = 0.05 + 0.95 * random.next_double();
      const double greater = 1.02 + 1.48 * random.next_double();
      const double eta = outside ? greater : 1.0 / greater;
      const DielectricReference r = integrate_dielectric(mu, roughness * roughness, eta);
      const DielectricAlbedo a = look_up(mu, roughness, eta);
      const double error = std::abs(static_cast<double>(a.e) / r.e - 1.0);
      worst = std::max(worst, error);
      squares_e += error * error;
      squares_reflected += std::pow(static_cast<double>(a.reflected) - r.reflected, 2.0);
      EXPECT_LT(error, outside ? 0.012 : 0.03) << mu << " " << roughness << " " << eta;
    }
    EXPECT_LT(std::sqrt(squares_e / kPoints), outside ? 0.003 : 0.006);
    EXPECT_LT(std::sqrt(squares_reflected / kPoints), outside ? 0.01 : 0.1);
    RecordProperty(outside ? "outside" : "inside", std::to_string(worst) + " rms " +
                                                       std::to_string(std::sqrt(squares_e / kPoints)) + " reflected " +
                                                       std::to_string(std::sqrt(squares_reflected / kPoints)));
  }
}

TEST(DielectricTables, ValuesStayInRange) {
  for (const float eta : {0.1f, 0.4f, 0.67f, 0.99f, 1.0f, 1.01f, 1.5f, 2.5f, 10.0f}) {
    for (int r = 0; r <= 40; ++r) {
      const float roughness = lerp(kStraightRoughness, 1.0f, static_cast<float>(r) / 40.0f);
      for (int m = 1; m <= 200; ++m) {
        const DielectricAlbedo a =
            dielectric_albedo(square(static_cast<float>(m) / 200.0f), roughness, roughness * roughness, eta);
        ASSERT_TRUE(a.e > 0.0f && a.e <= 1.0f && a.reflected >= 0.0f && a.reflected <= 1.0f);
      }
    }
  }
}

} // namespace
} // namespace kindling
