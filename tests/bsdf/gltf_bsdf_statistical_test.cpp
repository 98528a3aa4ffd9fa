// Statistical tests of the glTF BSDF: sampling against its pdf, white furnace, albedos.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/gltf_bsdf.h"

#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/chi_square.h"

#include "renderer/sampling/warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace kindling {
namespace {

using test::Random;
using test::view;

// Maximum error of a white furnace above mu = 0.001 by interpolation of the albedo tables: see
// ggx_albedo.h.
constexpr double kTableError = 2e-3;

std::string describe(const BsdfParameters& p, float mu) {
  return "roughness " + std::to_string(p.roughness) + " metallic " + std::to_string(p.metallic) + " specular " +
         std::to_string(p.specular) + " ior " + std::to_string(p.ior) + " mu " + std::to_string(mu);
}

std::vector<BsdfParameters> grid() {
  std::vector<BsdfParameters> all;
  for (const float roughness : {0.0f, 0.03f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f}) {
    for (const float metallic : {0.0f, 0.5f, 1.0f}) {
      for (const float specular : {1.0f, 0.3f}) {
        if (metallic == 1.0f && specular != 1.0f) continue;
        BsdfParameters p;
        p.base_color = {0.8f, 0.4f, 0.6f};
        p.roughness = roughness;
        p.metallic = metallic;
        p.specular = specular;
        all.push_back(p);
      }
    }
  }
  return all;
}

// Directions are floats: in grazing views of the narrowest lobes too few of them lie across the
// lobe for a count, so the views stay above grazing. The furnace below includes them.
TEST(GltfBsdfStatistical, SamplingMatchesPdf) {
  const std::vector<BsdfParameters> materials = grid();
  constexpr float kViews[] = {1.0f, 0.7f, 0.25f, 0.03f};
  const double level = test::sidak_level(0.01, static_cast<int>(materials.size() * std::size(kViews)));
  uint64_t seed = 100;
  for (const BsdfParameters& p : materials) {
    for (const float mu : kViews) {
      ++seed;
      if (p.roughness < 0.1f && mu < 0.1f) continue;
      const GltfBsdf bsdf(p, view(mu, 0.3f));
      const auto draw = [&](Random& random) -> std::optional<V3f> {
        const float u = random.next_1d();
        const auto s = bsdf.sample(u, random.next_2d());
        return s ? std::optional(s->wi) : std::nullopt;
      };
      test::ChiSquareOptions options = {
          .seed = seed, .samples = 100000, .bins = 128, .min_extent = 2e-5, .may_be_absorbed = true};
      const V3f mirror = view(mu, 0.8f);
      if (p.roughness < 0.1f) {
        options.peak = {static_cast<double>(mirror.x / (1.0f + mirror.z)),
                        static_cast<double>(mirror.y / (1.0f + mirror.z))};
      }
      const auto result = test::chi_square_hemisphere(
          draw, [&](const V3f& wi) { return bsdf.eval(wi).pdf; }, options);
      EXPECT_GT(result.p_value, level) << describe(p, mu) << ": " << result.summary;
      // The integral of the density and the absorbed fraction make up all draws, within four
      // standard errors of the fraction.
      const double error = std::sqrt(result.absorbed * (1.0 - result.absorbed) / 100000.0);
      EXPECT_NEAR(result.integral + result.absorbed, 1.0, 4.0 * error + 1e-3) << describe(p, mu);
    }
  }
}

struct Mean {
  Rgb value{0.0f};
  double error = 0.0; // standard error of the red channel
};

Mean mean_weight(const GltfBsdf& bsdf, uint64_t seed, int samples) {
  Random random(seed);
  double sum[3] = {0.0, 0.0, 0.0};
  double squares = 0.0;
  for (int i = 0; i < samples; ++i) {
    const float u = random.next_1d();
    const auto s = bsdf.sample(u, random.next_2d());
    if (!s) continue;
    for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(s->weight[c]);
    squares += static_cast<double>(s->weight.x) * static_cast<double>(s->weight.x);
  }
  const double mean = sum[0] / samples;
  return {Rgb(static_cast<float>(mean), static_cast<float>(sum[1] / samples), static_cast<float>(sum[2] / samples)),
          std::sqrt(std::max(squares / samples - mean * mean, 0.0) / samples)};
}

TEST(GltfBsdfStatistical, WhiteFurnace) {
  uint64_t seed = 1000;
  for (const float metallic : {0.0f, 0.4f, 1.0f}) {
    for (const float roughness : {0.0f, 0.03f, 0.1f, 0.2f, 0.4f, 0.6f, 0.8f, 1.0f}) {
      for (const float ior : {1.0f, 1.5f, 2.4f}) {
        for (const float mu : {1.0f, 0.8f, 0.4f, 0.15f, 0.05f, 0.01f, 0.002f}) {
          BsdfParameters p;
          p.metallic = metallic;
          p.roughness = roughness;
          p.ior = ior;
          const Mean mean = mean_weight(GltfBsdf(p, view(mu, 0.1f)), seed++, 20000);
          EXPECT_NEAR(static_cast<double>(mean.value.x), 1.0, kTableError + 4.5 * mean.error)
              << describe(p, mu) << " seed " << seed - 1;
        }
      }
    }
  }
}

TEST(GltfBsdfStatistical, ConservesEnergy) {
  Random random(9);
  for (uint64_t i = 0; i < 2000; ++i) {
    BsdfParameters p;
    p.base_color = {random.next_1d(), random.next_1d(), random.next_1d()};
    p.metallic = std::min(1.5f * random.next_1d(), 1.0f);
    p.roughness = random.next_1d();
    p.specular = random.next_1d();
    p.ior = 1.0f + 3.0f * random.next_1d();
    p.specular_color = {3.0f * random.next_1d(), 3.0f * random.next_1d(), 3.0f * random.next_1d()};
    const float mu = std::max(random.next_1d(), 1e-3f);
    const Mean mean = mean_weight(GltfBsdf(p, view(mu, random.next_1d())), 5000 + i, 4000);
    EXPECT_LT(static_cast<double>(max_component(mean.value)), 1.0 + kTableError + 5.0 * mean.error + 5e-3)
        << describe(p, mu) << " case " << i;
  }
}

// Integrates f cos over the hemisphere by midpoint quadrature in the square of the cosine warp,
// independently of GGX.
Rgb quadrature_albedo(const GltfBsdf& bsdf) {
  constexpr int kSide = 700;
  double sum[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const V3f wi =
          sample_cosine_hemisphere({(static_cast<float>(i) + 0.5f) / kSide, (static_cast<float>(j) + 0.5f) / kSide});
      const Rgb f = bsdf.eval(wi).value / cosine_hemisphere_pdf(wi);
      for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(f[c]);
    }
  }
  constexpr double kScale = 1.0 / (static_cast<double>(kSide) * kSide);
  return {static_cast<float>(sum[0] * kScale), static_cast<float>(sum[1] * kScale),
          static_cast<float>(sum[2] * kScale)};
}

TEST(GltfBsdfStatistical, AlbedoMatchesSamplingAndQuadrature) {
  uint64_t seed = 3000;
  for (const float metallic : {0.0f, 0.5f, 1.0f}) {
    for (const float roughness : {0.25f, 0.5f, 1.0f}) {
      for (const float mu : {0.95f, 0.5f, 0.2f}) {
        BsdfParameters p;
        p.base_color = {0.9f, 0.5f, 0.1f};
        p.metallic = metallic;
        p.roughness = roughness;
        p.specular_color = {1.0f, 0.6f, 0.2f};
        const GltfBsdf bsdf(p, view(mu, 0.6f));
        const Rgb by_quadrature = quadrature_albedo(bsdf);
        const Mean by_sampling = mean_weight(bsdf, seed++, 200000);
        const Rgb stated = bsdf.albedo();
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(static_cast<double>(by_sampling.value[c]), static_cast<double>(by_quadrature[c]),
                      4.5 * by_sampling.error + 5e-4)
              << describe(p, mu) << " channel " << c;
          EXPECT_NEAR(static_cast<double>(stated[c]), static_cast<double>(by_quadrature[c]), kTableError)
              << describe(p, mu) << " channel " << c;
        }
      }
    }
  }
}

// The estimator is efficient, not just correct: weights of smooth or white materials hardly vary.
TEST(GltfBsdfStatistical, WeightsHaveLowVariance) {
  uint64_t seed = 4000;
  for (const float metallic : {0.0f, 1.0f}) {
    for (const float roughness : {0.0f, 0.2f, 0.5f, 1.0f}) {
      for (const float mu : {0.9f, 0.5f, 0.1f}) {
        BsdfParameters p;
        p.metallic = metallic;
        p.roughness = roughness;
        constexpr int kSamples = 20000;
        const Mean mean = mean_weight(GltfBsdf(p, view(mu, 0.6f)), seed++, kSamples);
        EXPECT_LT(mean.error * std::sqrt(kSamples), 0.5) << describe(p, mu);
      }
    }
  }
}

} // namespace
} // namespace kindling
