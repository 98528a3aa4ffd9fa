// Tests of the quadrature of anisotropic dielectric interfaces against an independent, finer one.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/anisotropic_interface.h"
#include "renderer/bsdf/dielectric_albedo.h"

#include "tests/bsdf/layered_materials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace kindling {
namespace {

using test::Random;
using test::view;

struct InterfaceView {
  V3f wo;
  float alpha_x, alpha_y, eta;
};

// Integrates over all normals instead of the visible ones: slopes alpha t (cos psi, sin psi) with
// t^2 = u / (1 - u) make D cos(theta_h) uniform in u and psi. Returns the albedo with Fresnel term
// a + b F.
double integrate_interface(const InterfaceView& v, double a, double b) {
  constexpr int kRadial = 250;
  constexpr int kAngular = 250;
  const V3d wo(v.wo);
  const double alpha_x = static_cast<double>(v.alpha_x), alpha_y = static_cast<double>(v.alpha_y);
  const double eta = static_cast<double>(v.eta);
  const auto lambda = [&](const V3d& w) {
    return 0.5 * (std::sqrt(1.0 + (std::pow(alpha_x * w.x, 2.0) + std::pow(alpha_y * w.y, 2.0)) / (w.z * w.z)) - 1.0);
  };
  const double lambda_o = lambda(wo);
  double sum = 0.0;
  for (int i = 0; i < kRadial; ++i) {
    const double q = (i + 0.5) / kRadial;
    const double rest = (1.0 - q) * (1.0 - q); // 1 - u
    const double t = std::sqrt((1.0 - rest) / rest);
    const double shift = std::fmod(i * 0.7548776662, 1.0);
    for (int j = 0; j < kAngular; ++j) {
      const double psi = 2.0 * std::numbers::pi * (j + shift) / kAngular;
      const V3d h = V3d(alpha_x * t * std::cos(psi), alpha_y * t * std::sin(psi), 1.0).normalized();
      const double cos_d = wo.dot(h);
      if (cos_d <= 0.0) continue;
      const double measure = cos_d / (wo.z * h.z) * 2.0 * (1.0 - q);
      const auto g2 = [&](const V3d& wi) { return 1.0 / (1.0 + lambda_o + lambda(wi)); };
      const V3d reflected = 2.0 * cos_d * h - wo;
      const double reflection = reflected.z > 0.0 ? measure * g2(reflected) : 0.0;
      const double theta_o = std::acos(std::min(cos_d, 1.0));
      const double sine = std::sin(theta_o) / eta;
      if (sine >= 1.0) {
        sum += reflection;
        continue;
      }
      const double theta_t = std::asin(sine);
      const double f =
          a + b * (theta_o < 1e-4 ? std::pow((eta - 1.0) / (eta + 1.0), 2.0)
                                  : 0.5 * (std::pow(std::sin(theta_o - theta_t) / std::sin(theta_o + theta_t), 2.0) +
                                           std::pow(std::tan(theta_o - theta_t) / std::tan(theta_o + theta_t), 2.0)));
      const V3d refracted = h * (cos_d / eta - std::cos(theta_t)) - wo / eta;
      sum += f * reflection + (refracted.z < 0.0 ? (1.0 - f) * measure * g2(refracted) : 0.0);
    }
  }
  return sum / (static_cast<double>(kRadial) * kAngular);
}

InterfaceView random_view(Random& random, float eta) {
  const float roughness = 0.05f + 0.95f * random.next_1d();
  InterfaceView v;
  v.alpha_y = roughness * roughness;
  v.alpha_x = random.next_1d() < 0.3f ? 1.0f : lerp(v.alpha_y, 1.0f, square(random.next_1d()));
  if (random.next_1d() < 0.5f) std::swap(v.alpha_x, v.alpha_y);
  const V2f u = random.next_2d();
  v.wo = view(std::sqrt(4e-4f + 0.9996f * u.x), u.y); // as a sphere is seen
  v.eta = eta;
  return v;
}

// Verifies the errors that anisotropic_interface.h states. The relative error counts, since the
// albedo is a divisor; its mean is the error of a white furnace.
TEST(AnisotropicInterface, QuadratureStaysWithinStatedError) {
  constexpr int kViews = 120;
  for (const float eta : {1.05f, 1.5f, 2.4f, 1.0f / 1.05f, 1.0f / 1.5f, 1.0f / 2.4f}) {
    const bool outside = eta > 1.0f;
    Random random(static_cast<uint64_t>(eta * 1000.0f));
    double mean = 0.0, squares = 0.0, worst = 0.0;
    for (int i = 0; i < kViews; ++i) {
      const InterfaceView v = random_view(random, eta);
      const double a = i % 3 == 0 ? 0.4 * static_cast<double>(random.next_1d()) : 0.0; // KHR_materials_specular
      const double b = i % 3 == 0 ? (1.0 - a) * static_cast<double>(random.next_1d()) : 1.0;
      const float albedo =
          anisotropic_interface(v.wo, v.alpha_x, v.alpha_y, eta).albedo(static_cast<float>(a), static_cast<float>(b));
      const double error = static_cast<double>(albedo) / integrate_interface(v, a, b) - 1.0;
      EXPECT_LT(std::abs(error), outside ? 0.005 : 0.02)
          << v.wo << " alpha " << v.alpha_x << " " << v.alpha_y << " eta " << eta << " a " << a << " b " << b;
      mean += error / kViews;
      squares += error * error / kViews;
      worst = std::max(worst, std::abs(error));
    }
    EXPECT_LT(std::sqrt(squares), outside ? 0.0012 : 0.0035) << eta;
    EXPECT_LT(std::abs(mean), 5e-4 + 3.5 * std::sqrt(squares / kViews)) << eta;
    RecordProperty("eta" + std::to_string(eta), "worst " + std::to_string(worst) + " rms " +
                                                    std::to_string(std::sqrt(squares)) + " mean " +
                                                    std::to_string(mean));
  }
}

// Without anisotropy it equals the tables up to both errors.
TEST(AnisotropicInterface, AgreesWithIsotropicTables) {
  Random random(7);
  for (int i = 0; i < 2000; ++i) {
    const float roughness = 0.05f + 0.95f * random.next_1d();
    const float alpha = roughness * roughness;
    const float greater = 1.02f + 1.4f * random.next_1d();
    const float eta = i % 2 == 0 ? greater : 1.0f / greater;
    const V2f u = random.next_2d();
    const V3f wo = view(0.02f + 0.98f * u.x, u.y);
    const DielectricAlbedo table = dielectric_albedo(wo.z, roughness, alpha, eta);
    const InterfaceIntegrals seen = anisotropic_interface(wo, alpha, alpha, eta);
    const float tolerance = eta > 1.0f ? 0.02f : 0.06f;
    EXPECT_NEAR(seen.albedo(0.0f, 1.0f), table.e, tolerance) << wo << " " << roughness << " " << eta;
    EXPECT_NEAR(seen.reflected - seen.transmitted, table.p, 1.5f * tolerance) << wo << " " << roughness << " " << eta;
    EXPECT_NEAR(seen.reflected_f - seen.transmitted_f, table.q, 1.5f * tolerance)
        << wo << " " << roughness << " " << eta;
  }
}

TEST(AnisotropicInterface, ExtremeViewsAreFinite) {
  for (const float eta : {1e-4f, 0.3f, 0.98f, 1.02f, 3.0f, 1e4f}) {
    for (const float mu : {1e-4f, 1e-2f, 0.5f, 1.0f}) {
      for (const float turns : {0.0f, 0.1f, 0.25f}) {
        for (const float alpha : {9e-4f, 0.1f, 1.0f}) {
          const InterfaceIntegrals seen = anisotropic_interface(view(mu, turns), 1.0f, alpha, eta);
          const float albedo = seen.albedo(0.0f, 1.0f);
          EXPECT_TRUE(albedo > 0.0f && albedo <= 1.00001f) << eta << " " << mu << " " << turns << " " << alpha;
        }
      }
    }
  }
}

} // namespace
} // namespace kindling
