// Tests of the anisotropic albedo tables against an independent quadrature.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/anisotropic_albedo.h"

#include "tests/bsdf/layered_materials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kindling {
namespace {

using test::Random;
using test::view;

struct AnisotropicReference {
  double e = 0.0;
  double b = 0.0;
};

// Integrates over half vectors: slopes alpha t (cos psi, sin psi) with t^2 = u / (1 - u) make D
// cos(theta_h) uniform in u and psi.
AnisotropicReference integrate_anisotropic(const V3d& wo, double alpha_x, double alpha_y) {
  constexpr int kRadial = 250;
  constexpr int kAngular = 250;
  const auto stretched = [&](const V3d& w) { return std::hypot(alpha_x * w.x, alpha_y * w.y, w.z); };
  const double t_o = stretched(wo);
  AnisotropicReference sum;
  for (int i = 0; i < kRadial; ++i) {
    const double v = (i + 0.5) / kRadial;
    const double rest = (1.0 - v) * (1.0 - v); // 1 - u
    const double t = std::sqrt((1.0 - rest) / rest);
    const double shift = std::fmod(i * 0.7548776662, 1.0);
    for (int j = 0; j < kAngular; ++j) {
      const double psi = 2.0 * std::numbers::pi * (j + shift) / kAngular;
      const V3d h = V3d(alpha_x * t * std::cos(psi), alpha_y * t * std::sin(psi), 1.0).normalized();
      const double cos_d = wo.dot(h);
      const V3d wi = 2.0 * cos_d * h - wo;
      if (cos_d <= 0.0 || wi.z <= 0.0) continue;
      const double visibility = 0.5 / (wi.z * t_o + wo.z * stretched(wi));
      // D cos(theta_h) dh = du dpsi / (2 pi); du = 2 (1 - v) dv.
      const double f = visibility * wi.z * 4.0 * cos_d / h.z * 2.0 * (1.0 - v);
      sum.e += f;
      sum.b += f * std::pow(1.0 - cos_d, 5.0);
    }
  }
  const double n = 1.0 / (static_cast<double>(kRadial) * kAngular);
  return {sum.e * n, sum.b * n};
}

// Verifies the accuracy that anisotropic_albedo.h states.
TEST(AnisotropicTables, LookupStaysWithinStatedError) {
  Random random(1);
  double worst = 0.0;
  double squares = 0.0;
  constexpr int kCases = 150;
  for (int i = 0; i < kCases; ++i) {
    const float roughness = 0.02f + 0.98f * random.next_1d();
    const float alpha_y = roughness * roughness;
    const float alpha_x = lerp(alpha_y, 1.0f, square(random.next_1d()));
    const V2f u = random.next_2d();
    const V3f wo = view(0.02f + 0.98f * u.x, u.y);
    const AnisotropicReference reference =
        integrate_anisotropic(V3d(wo), static_cast<double>(alpha_x), static_cast<double>(alpha_y));
    const GgxAlbedo a = AnisotropicAlbedoTable(alpha_x, alpha_y)(wo);
    const double error_e = static_cast<double>(a.e) - reference.e;
    const double error_b = static_cast<double>(a.b) - reference.b;
    EXPECT_LT(std::abs(error_e), 1.2e-2) << wo << " alpha " << alpha_x << " " << alpha_y << " E " << reference.e;
    EXPECT_LT(std::abs(error_b), 8e-3) << wo << " alpha " << alpha_x << " " << alpha_y << " B " << reference.b;
    worst = std::max({worst, std::abs(error_e), std::abs(error_b)});
    squares += error_e * error_e;
  }
  EXPECT_LT(std::sqrt(squares / kCases), 2.5e-3);
  RecordProperty("worst", std::to_string(worst));
  RecordProperty("rms", std::to_string(std::sqrt(squares / kCases)));
}

// Without anisotropy it equals GgxAlbedoTable up to its coarser grid, with x and y not swapped.
TEST(AnisotropicTables, AgreesWithIsotropicTable) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const float roughness = 0.02f + 0.98f * random.next_1d();
    const float alpha = roughness * roughness;
    const V2f u = random.next_2d();
    const V3f wo = view(0.02f + 0.98f * u.x, u.y);
    const GgxAlbedo a = AnisotropicAlbedoTable(alpha, alpha)(wo);
    const GgxAlbedo b = GgxAlbedoTable(roughness, alpha)(wo.z);
    EXPECT_NEAR(a.e, b.e, 6e-3f) << roughness << " " << wo;
    EXPECT_NEAR(a.b, b.b, 6e-3f) << roughness << " " << wo;
    const float alpha_x = lerp(alpha, 1.0f, random.next_1d());
    const GgxAlbedo turned = AnisotropicAlbedoTable(alpha, alpha_x)(V3f(wo.y, -wo.x, -wo.z));
    const GgxAlbedo straight = AnisotropicAlbedoTable(alpha_x, alpha)(wo);
    EXPECT_NEAR(turned.e, straight.e, 1e-5f);
  }
}

TEST(AnisotropicTables, AveragesMatchLookup) {
  for (const float roughness : {0.05f, 0.3f, 0.7f}) {
    for (const float alpha_x : {0.5f, 1.0f}) {
      const AnisotropicAlbedoTable table(alpha_x, roughness * roughness);
      constexpr int kSide = 200;
      double e = 0.0;
      double b = 0.0;
      for (int i = 0; i < kSide; ++i) {
        for (int j = 0; j < kSide; ++j) {
          const float mu = std::sqrt((static_cast<float>(i) + 0.5f) / kSide);
          const GgxAlbedo a = table(view(mu, (static_cast<float>(j) + 0.5f) / kSide));
          e += static_cast<double>(a.e) / (kSide * kSide);
          b += static_cast<double>(a.b) / (kSide * kSide);
        }
      }
      const GgxAlbedo mean = anisotropic_average_albedo(std::sqrt(alpha_x), roughness);
      EXPECT_NEAR(static_cast<double>(mean.e), e, 1.5e-3) << roughness << " " << alpha_x;
      EXPECT_NEAR(static_cast<double>(mean.b), b, 1.5e-3) << roughness << " " << alpha_x;
    }
  }
}

} // namespace
} // namespace kindling
