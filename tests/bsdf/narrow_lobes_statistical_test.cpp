// Narrow lobes: sampling against the density, and the parts of a BSDF against the whole.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/narrow_lobes.h"

#include "tests/bsdf/follows_density.h"
#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/estimate.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::LayeredMaterial;
using test::Random;
using test::view;

constexpr float kMaxAlpha = 0.1225f;

LayeredMaterial coat_over(float roughness) {
  LayeredMaterial m;
  m.base = {.base_color = Rgb(0.6f, 0.2f, 0.1f), .metallic = 0.2f, .roughness = roughness};
  m.layers.clearcoat = 0.8f;
  m.layers.clearcoat_roughness = 0.25f;
  m.layers.clearcoat_normal = view(0.97f, 0.6f);
  m.layers.sheen_color = Rgb(0.3f);
  m.layers.sheen_roughness = 0.5f;
  return m;
}

// The density of sample_narrow() follows from the shares of the whole density.
TEST(NarrowLobesStatistical, SamplingMatchesTheShare) {
  const LayeredMaterial over_rough = coat_over(0.7f), over_smooth = coat_over(0.3f);
  const LayeredMaterial plain{.base = {.base_color = Rgb(0.5f), .metallic = 0.3f, .roughness = 0.3f}, .layers = {}};
  uint64_t seed = 40;
  const double level = test::sidak_level(0.01, 9);
  for (const LayeredMaterial* material : {&over_rough, &over_smooth, &plain})
    for (const float mu : {1.0f, 0.6f, 0.15f}) {
      ++seed;
      const SurfaceBsdf bsdf(material->base, material == &plain ? nullptr : &material->layers, view(mu, 0.3f));
      const float probability = narrow_probability(bsdf, kMaxAlpha);
      ASSERT_GT(probability, 0.0f);
      const auto draw = [&](Random& random) -> std::optional<V3f> {
        const float u = random.next_1d();
        const auto s = sample_narrow(bsdf, u, random.next_2d(), kMaxAlpha);
        if (!s) return std::nullopt;
        EXPECT_NEAR(max_component(s->weight) * s->pdf, max_component(bsdf.eval(s->wi).value),
                    1e-3f * max_component(s->weight) * s->pdf);
        return s->wi;
      };
      const auto density = [&](const V3f& wi) {
        const float pdf = bsdf.eval(wi).pdf;
        return pdf > 0.0f ? narrow_share(bsdf, wi, pdf, kMaxAlpha) * pdf / probability : 0.0f;
      };
      test::expect_directions_follow(draw, density, seed, 100000, level, "seed " + std::to_string(seed));
    }
}

// The narrow part of a BSDF's albedo is the same by sampling the narrow lobes and by sampling all.
TEST(NarrowLobesStatistical, PartsAddUp) {
  Random materials(7);
  int with_parts = 0;
  for (int i = 0; i < 40; ++i) {
    const LayeredMaterial m = test::random_material(materials, 0.1f);
    const float mu = 0.1f + 0.9f * materials.next_1d();
    const SurfaceBsdf bsdf(m.base, &m.layers, view(mu, 0.2f));
    const float probability = narrow_probability(bsdf, kMaxAlpha);
    Random random(static_cast<uint64_t>(i) + 100);
    test::Estimate narrow, of_all;
    for (int n = 0; n < 20000; ++n) {
      const float u = random.next_1d();
      const V2f direction = random.next_2d();
      const auto share_of = [&](const BsdfSample& s) {
        const float pdf = s.pdf == 0.0f ? 0.0f : bsdf.eval(s.wi).pdf;
        return s.pdf == 0.0f || pdf > 0.0f ? narrow_share(bsdf, s.wi, pdf, kMaxAlpha) : 0.0f;
      };
      const auto by_narrow = sample_narrow(bsdf, u, direction, kMaxAlpha);
      narrow.add(by_narrow ? static_cast<double>(luminance(by_narrow->weight) * share_of(*by_narrow)) : 0.0);
      const auto by_all = bsdf.sample(u, direction);
      of_all.add(by_all ? static_cast<double>(luminance(by_all->weight) * share_of(*by_all)) : 0.0);
    }
    const double error = std::hypot(narrow.standard_error(), of_all.standard_error());
    EXPECT_NEAR(narrow.mean(), of_all.mean(), 4.5 * error + 1e-4) << test::describe(m, mu);
    EXPECT_TRUE(probability > 0.0f || narrow.mean() == 0.0) << test::describe(m, mu);
    if (probability > 0.02f && probability < 0.98f) ++with_parts;
  }
  EXPECT_GT(with_parts, 10);
}

TEST(NarrowLobes, RoughSurfacesHaveNone) {
  const SurfaceBsdf rough({.base_color = Rgb(0.5f), .metallic = 1.0f, .roughness = 0.6f}, nullptr, view(0.7f, 0.0f));
  EXPECT_EQ(narrow_probability(rough, kMaxAlpha), 0.0f);
  EXPECT_FALSE(sample_narrow(rough, 0.5f, V2f(0.3f, 0.4f), kMaxAlpha));
  const SurfaceBsdf mirror({.base_color = Rgb(0.5f), .metallic = 1.0f, .roughness = 0.2f}, nullptr, view(0.7f, 0.0f));
  EXPECT_GT(narrow_probability(mirror, kMaxAlpha), 0.9f);
}

} // namespace
} // namespace kindling
