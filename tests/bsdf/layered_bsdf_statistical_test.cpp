// Statistical tests of the layered BSDF: sampling against its pdf, furnaces, albedos.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/layered_bsdf.h"

#include "tests/bsdf/follows_density.h"
#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::describe;
using test::LayeredMaterial;
using test::mean_weight;
using test::MeanWeight;
using test::Random;
using test::random_material;
using test::view;
using test::whitened;

struct Case {
  LayeredMaterial material;
  float mu;
};

void expect_samples_follow_density(const std::vector<Case>& cases, uint64_t seed, int samples) {
  const double level = test::sidak_level(0.01, static_cast<int>(cases.size()));
  for (const Case& c : cases) {
    ++seed;
    const LayeredBsdf bsdf(c.material.base, c.material.layers, view(c.mu, 0.3f));
    const auto draw = [&](Random& random) -> std::optional<V3f> {
      const float u = random.next_1d();
      const auto s = bsdf.sample(u, random.next_2d());
      return s && s->pdf > 0.0f ? std::optional(s->wi) : std::nullopt;
    };
    test::expect_directions_follow(
        draw, [&](const V3f& wi) { return bsdf.eval(wi).pdf; }, seed, samples, level, describe(c.material, c.mu));
  }
}

// One lobe at a time above the surface, over its own parameters.
TEST(LayeredBsdfStatistical, SamplingOfEachLobeMatchesPdf) {
  LayeredMaterial black;
  black.base.base_color = Rgb(0.0f);
  black.base.metallic = black.base.specular = 0.0f;
  std::vector<Case> cases;
  for (const float mu : {1.0f, 0.6f, 0.1f}) {
    for (const float roughness : {0.15f, 0.4f, 1.0f}) {
      LayeredMaterial m = black;
      m.layers.sheen_color = Rgb(1.0f);
      m.layers.sheen_roughness = roughness;
      cases.push_back({m, mu});
      m = black;
      m.layers.clearcoat = 1.0f;
      m.layers.clearcoat_roughness = roughness;
      m.layers.clearcoat_normal = view(0.9f, 0.45f);
      cases.push_back({m, mu});
      for (const float anisotropy : {0.5f, 1.0f}) {
        m = black;
        m.base.base_color = Rgb(1.0f);
        m.base.metallic = 1.0f;
        m.base.roughness = roughness;
        m.layers.anisotropy = anisotropy;
        cases.push_back({m, mu});
      }
    }
  }
  expect_samples_follow_density(cases, 100, 40000);
}

// Tests on a fixed grid over both hemispheres, which detects the weakest of many lobes as reliably
// as the strongest, unless it is narrower than the midpoint rule of each bin (0.007 in the root of
// z, 0.026 in azimuth). Gives the p value of the counts; absorbed samples are one more bin.
struct GridResult {
  double p_value;
  double total; // of the density and the absorbed samples
};
GridResult grid_test(const LayeredBsdf& bsdf, uint64_t seed, int samples) {
  constexpr int kRows = 24; // of each hemisphere
  constexpr int kColumns = 40;
  constexpr int kSteps = 6;
  constexpr int kBins = 2 * kRows * kColumns;
  std::vector<double> expected(kBins + 1, 0.0);
  std::vector<double> observed(kBins + 1, 0.0);
  const auto bin_of = [](const V3f& w) {
    const int row = std::min(static_cast<int>(std::sqrt(std::abs(w.z)) * kRows), kRows - 1);
    const double turns = std::atan2(static_cast<double>(w.y), static_cast<double>(w.x)) / (2.0 * std::numbers::pi);
    const int column = static_cast<int>((turns - std::floor(turns)) * kColumns) % kColumns;
    return ((w.z < 0.0f ? kRows : 0) + row) * kColumns + column;
  };
  double integral = 0.0;
  for (int i = 0; i < kRows * kSteps; ++i) {
    for (int j = 0; j < kColumns * kSteps; ++j) {
      const float root = (static_cast<float>(i) + 0.5f) / (kRows * kSteps); // rows are evenly spaced in the root of z
      V3f w = view(root * root, (static_cast<float>(j) + 0.5f) / (kColumns * kSteps));
      for (int side = 0; side < 2; ++side, w.z = -w.z) {
        const double mass = static_cast<double>(bsdf.eval(w).pdf * root) * 4.0 * std::numbers::pi /
                            (kRows * kSteps * kColumns * kSteps);
        integral += mass;
        expected[static_cast<size_t>(bin_of(w))] += mass * samples;
      }
    }
  }
  Random random(seed);
  for (int i = 0; i < samples; ++i) {
    const float u = random.next_1d();
    const auto s = bsdf.sample(u, random.next_2d());
    observed[static_cast<size_t>(s && s->pdf > 0.0f ? bin_of(s->wi) : kBins)] += 1.0;
  }
  expected[kBins] = std::max(1.0 - integral, 0.0) * samples;
  // Bins with small expected counts are pooled.
  double statistic = 0.0;
  double pooled_expected = 0.0;
  double pooled_observed = 0.0;
  int cells = 0;
  const auto close = [&](double e, double o) {
    statistic += (o - e) * (o - e) / e;
    ++cells;
  };
  for (size_t i = 0; i <= kBins; ++i) {
    if (expected[i] >= 8.0 && i < kBins) {
      close(expected[i], observed[i]);
      continue;
    }
    pooled_expected += expected[i];
    pooled_observed += observed[i];
    if (pooled_expected < 8.0) continue;
    close(pooled_expected, pooled_observed);
    pooled_expected = pooled_observed = 0.0;
  }
  if (pooled_expected + pooled_observed > 0.0) close(std::max(pooled_expected, 1.0), pooled_observed);
  return {test::chi_square_tail(statistic, std::max(cells - 1, 1)), integral + observed[kBins] / samples};
}

TEST(LayeredBsdfStatistical, SamplingOfRandomMaterialsMatchesPdf) {
  constexpr int kCases = 200;
  constexpr int kSamples = 20000;
  Random random(7);
  for (uint64_t i = 0; i < kCases; ++i) {
    LayeredMaterial m = random_material(random, 0.4f);
    if (m.base.ior < 1.3f) m.base.ior = m.layers.eta = 1.3f; // weak refraction would stay in a narrow lobe
    const float mu = 0.15f + 0.85f * random.next_1d();
    const GridResult result = grid_test(LayeredBsdf(m.base, m.layers, view(mu, random.next_1d())), 1000 + i, kSamples);
    EXPECT_GT(result.p_value, test::sidak_level(0.01, kCases)) << i << describe(m, mu) << ": total " << result.total;
    EXPECT_NEAR(result.total, 1.0, 4.5 * 0.5 / std::sqrt(kSamples)) << i << describe(m, mu);
  }
}

// Maximum gain and loss of each model, and the maximum error of albedo(): the figures of
// renderer/bsdf/README.md.
struct Bounds {
  double above = 2e-3; // tables of GGX: see ggx_albedo.h
  double below = 2e-3;
  double albedo = 2e-3;
};
Bounds bounds_of(const LayeredMaterial& m, float mu) {
  Bounds b;
  const LayerParameters& l = m.layers;
  const auto add = [&](double above, double below, double albedo) {
    b.above += above;
    b.below += below;
    b.albedo += albedo;
  };
  // A tilted coat sends light below the horizon of the base, where it is lost.
  if (l.clearcoat > 0.0f && l.clearcoat_normal.z < 1.0f) add(0.0, 1.0, 1.0);
  if (max_component(l.sheen_color) > 0.0f) {
    // The sheen takes from light that grazes more than it reflects towards wo; how much of a rough
    // lobe grazes is estimated.
    const SheenLobe sheen(std::max(l.sheen_roughness, kMinSheenRoughness), view(mu, 0.0f));
    const auto lost = static_cast<double>(max_component(l.sheen_color) * (sheen.greater_albedo() - sheen.albedo()));
    add(5e-3, 2.5e-2 + 1.5 * lost, 2.5e-2 + 0.3 * lost);
  }
  if (l.anisotropy > 0.0f) add(1.2e-2, 1.2e-2, 1.2e-2);
  const auto film = static_cast<double>(l.iridescence);
  add(2e-2 * film, 3e-2 * film, 6e-2 * film);
  if (l.transmission > 0.0f) {
    add(5e-3, 1e-2, 2e-2 + 8e-2 * film);
    if (l.anisotropy > 0.0f && !l.thin_walled) add(3e-2, 3e-2, 3e-2);
    if (!l.thin_walled && l.eta < 1.0f) add(0.0, 0.0, 0.2);
  }
  return b;
}

// Tests the brightest channel: a film takes from the base the reflectance of its brightest channel,
// in all channels.
TEST(LayeredBsdfStatistical, WhiteFurnaceOfRandomMaterials) {
  Random random(8);
  for (uint64_t i = 0; i < 200; ++i) {
    LayeredMaterial m = whitened(random_material(random, 0.0f));
    if (i % 4 != 0) m.layers.clearcoat_normal = {0.0f, 0.0f, 1.0f};
    const float mu = 0.01f + 0.99f * random.next_1d();
    const LayeredBsdf bsdf(m.base, m.layers, view(mu, random.next_1d()));
    const MeanWeight mean = mean_weight(bsdf, 2000 + i, 10000);
    const Bounds bounds = bounds_of(m, mu);
    const double value = static_cast<double>(max_component(mean.value + bsdf.straight_transmittance()));
    const double error = 4.5 * static_cast<double>(max_component(mean.error));
    EXPECT_LT(value, 1.0 + bounds.above + error) << i << describe(m, mu);
    EXPECT_GT(value, 1.0 - bounds.below - error) << i << describe(m, mu);
  }
}

TEST(LayeredBsdfStatistical, AlbedoMatchesSampling) {
  Random random(9);
  for (uint64_t i = 0; i < 200; ++i) {
    LayeredMaterial m = random_material(random, 0.0f);
    m.layers.clearcoat_normal = {0.0f, 0.0f, 1.0f};
    const float mu = 0.01f + 0.99f * random.next_1d();
    const LayeredBsdf bsdf(m.base, m.layers, view(mu, random.next_1d()));
    const MeanWeight mean = mean_weight(bsdf, 4000 + i, 10000);
    const Bounds bounds = bounds_of(m, mu);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(static_cast<double>(mean.value[c]), static_cast<double>(bsdf.albedo()[c]),
                  bounds.albedo + 4.7 * static_cast<double>(mean.error[c]))
          << i << describe(m, mu) << " channel " << c;
    }
  }
}

} // namespace
} // namespace kindling
