// Tests of the sheen lobe (formulas, albedo table, sampling quality) and of fast_pow.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/sheen_lobe.h"

#include "tests/bsdf/layered_materials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kindling {
namespace {

using test::Random;
using test::view;

// KHR_materials_sheen, "Sheen distribution" and "Sheen visibility", in double precision.
double l_of(double x, double alpha) {
  const double t = (1.0 - alpha) * (1.0 - alpha);
  const auto mix = [t](double a, double b) { return a * (1.0 - t) + b * t; };
  return mix(21.5473, 25.3245) / (1.0 + mix(3.82987, 3.32435) * std::pow(x, mix(0.19823, 0.16801))) +
         mix(-1.97760, -1.27393) * x + mix(-4.32054, -4.85967);
}
double lambda(double mu, double alpha) {
  return mu < 0.5 ? std::exp(l_of(mu, alpha)) : std::exp(2.0 * l_of(0.5, alpha) - l_of(1.0 - mu, alpha));
}
double sheen(const V3d& wo, const V3d& wi, double roughness) { // f |cos_theta_i|
  const double alpha = roughness * roughness;
  const V3d h = (wo + wi).normalized();
  const double d =
      (2.0 + 1.0 / alpha) * std::pow(std::max(1.0 - h.z * h.z, 0.0), 0.5 / alpha) / (2.0 * std::numbers::pi);
  return d / (4.0 * wo.z * (1.0 + lambda(wo.z, alpha) + lambda(wi.z, alpha)));
}
V3d direction(double mu, double phi) {
  const double r = std::sqrt(1.0 - mu * mu);
  return {r * std::cos(phi), r * std::sin(phi), mu};
}

TEST(SheenLobe, MatchesSpecificationFormula) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const float roughness = kSheenGainRoughness + (1.0f - kSheenGainRoughness) * random.next_1d();
    const V2f uo = random.next_2d(), ui = random.next_2d();
    const V3f wo = view(0.005f + 0.995f * uo.x, uo.y);
    const V3f wi = view(0.005f + 0.995f * ui.x, ui.y);
    const double expected = sheen(V3d(wo), V3d(wi), static_cast<double>(roughness));
    // sin^2(theta_h) has an error of 1e-7, which the exponent 1 / (2 alpha) magnifies where it is
    // small.
    const double sine2 = 1.0 - square((wo + wi).normalized().z);
    const double tolerance = 2e-5 + 2e-7 / (sine2 * static_cast<double>(roughness * roughness) + 1e-12);
    if (expected < 1e-20) continue;
    EXPECT_NEAR(static_cast<double>(SheenLobe(roughness, wo).eval(wi).value) / expected, 1.0, tolerance)
        << roughness << " " << wo << " " << wi;
  }
}

// E(mu, roughness) of the specification, by an independent quadrature.
TEST(SheenLobe, AlbedoTableMatchesQuadrature) {
  for (const float roughness : {0.31f, 0.42f, 0.6f, 0.777f, 1.0f}) {
    for (const float mu : {0.013f, 0.07f, 0.21f, 0.5f, 0.77f, 1.0f}) {
      constexpr int kSide = 500;
      double sum = 0.0;
      for (int i = 0; i < kSide; ++i) {
        const double u = (i + 0.5) / kSide; // mu_i = u^2
        for (int j = 0; j < kSide / 2; ++j) {
          const double phi = 2.0 * std::numbers::pi * (j + 0.5) / kSide;
          sum += 2.0 * u *
                 sheen(direction(static_cast<double>(mu), 0.0), direction(u * u, phi), static_cast<double>(roughness));
        }
      }
      const double e = 2.0 * sum * 2.0 * std::numbers::pi / (static_cast<double>(kSide) * kSide);
      EXPECT_NEAR(static_cast<double>(SheenLobe(roughness, view(mu, 0.0f)).albedo()), e, 4e-3)
          << roughness << " " << mu;
    }
  }
}

// The mean that a Lambertian base loses, by a quadrature over the same albedos.
TEST(SheenLobe, GreaterAlbedoIsMeanOverDirections) {
  for (const float roughness : {kMinSheenRoughness, 0.12f, 0.31f, 0.5f, 0.777f, 1.0f}) {
    for (const float mu : {0.004f, 0.07f, 0.21f, 0.5f, 0.77f, 1.0f}) {
      const SheenLobe lobe(roughness, view(mu, 0.0f));
      EXPECT_EQ(lobe.albedo(mu), lobe.albedo());
      constexpr int kSteps = 20000;
      double sum = 0.0;
      for (int i = 0; i < kSteps; ++i) {
        const float mu_i = (static_cast<float>(i) + 0.5f) / kSteps;
        sum += static_cast<double>(2.0f * mu_i * std::max(lobe.albedo(mu_i), lobe.albedo())) / kSteps;
      }
      EXPECT_NEAR(static_cast<double>(lobe.greater_albedo()), sum, 2e-3) << roughness << " " << mu;
      EXPECT_GE(lobe.greater_albedo(), lobe.albedo() - 1e-6f);
    }
  }
}

TEST(SheenLobe, ConservesEnergy) {
  for (int r = 0; r <= 100; ++r) {
    const float roughness = lerp(kMinSheenRoughness, 1.0f, static_cast<float>(r) / 100.0f);
    for (int m = 1; m <= 100; ++m) {
      const float e = SheenLobe(roughness, view(square(static_cast<float>(m) / 100.0f), 0.0f)).albedo();
      ASSERT_TRUE(e >= 0.0f && e <= 1.0f) << roughness << " " << m << " " << e;
    }
  }
}

// Verifies the variance of the weights. The cosine lobe has 0.3 to 15 here.
TEST(SheenLobe, WeightsHaveLowVariance) {
  for (const float roughness : {0.25f, 0.5f, 1.0f}) {
    for (const float mu : {0.9f, 0.5f, 0.15f}) {
      const SheenLobe lobe(roughness, view(mu, 0.3f));
      Random random(11);
      constexpr int kSamples = 20000;
      double sum = 0.0;
      double squares = 0.0;
      double cosine = 0.0;
      for (int i = 0; i < kSamples; ++i) {
        const V2f u = random.next_2d();
        const V3f wi = lobe.sample(u);
        if (wi.z > 0.0f) {
          const SheenLobe::Eval e = lobe.eval(wi);
          const auto w = static_cast<double>(e.value / e.pdf);
          sum += w;
          squares += w * w;
        }
        const V3f wc = sample_cosine_hemisphere(u);
        if (wc.z > 0.0f) cosine += square(lobe.eval(wc).value / (wc.z * kInvPi));
      }
      const double mean = sum / kSamples;
      const double variance = squares / kSamples / (mean * mean) - 1.0;
      const double by_cosine = cosine / kSamples / (mean * mean) - 1.0;
      RecordProperty("variance", std::to_string(variance) + " cosine " + std::to_string(by_cosine));
      EXPECT_LT(variance, 0.5) << roughness << " " << mu;
      EXPECT_LT(variance, 0.25 * by_cosine) << roughness << " " << mu;
    }
  }
}

TEST(FastPow, MatchesStdPow) {
  Random random(2);
  for (int i = 0; i < 100000; ++i) {
    const float x = 1e-6f + random.next_1d();
    const float y = 100.0f * square(random.next_1d());
    const double expected = std::pow(static_cast<double>(x), static_cast<double>(y));
    if (expected < 1e-37) {
      EXPECT_LT(fast_pow(x, y), 2e-37f);
      continue;
    }
    const double logarithm = std::abs(static_cast<double>(y) * std::log2(static_cast<double>(x)));
    EXPECT_NEAR(static_cast<double>(fast_pow(x, y)) / expected, 1.0,
                1e-6 + 2e-7 * logarithm + 2e-7 * static_cast<double>(y))
        << x << " " << y;
  }
  EXPECT_EQ(fast_pow(0.0f, 2.0f), 0.0f);
  EXPECT_EQ(fast_pow(1.0f, 7.0f), 1.0f);
  EXPECT_EQ(fast_exp2(-1000.0f), 0.0f);
}

} // namespace
} // namespace kindling
