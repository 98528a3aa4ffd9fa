// Directions of the coat and of the glossy base alone, against their density.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/surface_bsdf.h"

#include "tests/bsdf/follows_density.h"
#include "tests/bsdf/layered_materials.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kindling {
namespace {

using test::LayeredMaterial;
using test::Random;
using test::view;

LayeredMaterial coated_glossy() {
  LayeredMaterial m;
  m.base = {.base_color = Rgb(0.6f, 0.2f, 0.1f), .metallic = 0.4f, .roughness = 0.6f};
  m.layers.clearcoat = 0.8f;
  m.layers.clearcoat_roughness = 0.3f;
  m.layers.clearcoat_normal = view(0.97f, 0.6f);
  m.layers.sheen_color = Rgb(0.3f);
  m.layers.anisotropy = 0.5f;
  return m;
}

TEST(ReflectionSamplingStatistical, DirectionsHaveTheDensity) {
  const LayeredMaterial coated = coated_glossy();
  LayeredMaterial frosted = coated; // glass is not among the lobes
  frosted.layers.transmission = 0.7f;
  const LayeredMaterial plain{.base = {.base_color = Rgb(0.5f), .metallic = 0.3f, .roughness = 0.4f}, .layers = {}};
  uint64_t seed = 90;
  const double level = test::sidak_level(0.01, 9);
  for (const LayeredMaterial* material : std::initializer_list<const LayeredMaterial*>{&coated, &frosted, &plain})
    for (const float mu : {1.0f, 0.6f, 0.15f}) {
      ++seed;
      const SurfaceBsdf bsdf(material->base, material == &plain ? nullptr : &material->layers, view(mu, 0.3f));
      ASSERT_TRUE(bsdf.has_microfacets());
      const auto draw = [&](Random& random) -> std::optional<V3f> {
        const float u = random.next_1d();
        const V3f wi = bsdf.sample_reflection(u, random.next_2d());
        return wi.z > 0.0f ? std::optional(wi) : std::nullopt;
      };
      const auto density = [&](const V3f& wi) { return bsdf.eval(wi).reflection_pdf; };
      test::expect_directions_follow(draw, density, seed, 100000, level, "seed " + std::to_string(seed));
    }
}

// A sample of all lobes comes with the density that these directions alone have there.
TEST(ReflectionSamplingStatistical, SamplesCarryTheDensity) {
  Random random(17);
  int positive = 0;
  for (int i = 0; i < 100000; ++i) {
    const LayeredMaterial m = test::random_material(random, 0.1f);
    const V3f wo = test::random_direction(random);
    const SurfaceBsdf bsdf(m.base, i % 4 == 0 ? nullptr : &m.layers, wo);
    const float u = random.next_1d();
    const auto s = bsdf.sample(u, random.next_2d());
    if (!s) continue;
    if (s->pdf == 0.0f || s->wi.z < 0.0f) {
      ASSERT_EQ(s->reflection_pdf, 0.0f);
      continue;
    }
    const float expected = bsdf.eval(s->wi).reflection_pdf;
    ASSERT_NEAR(s->reflection_pdf, expected, 1e-4f * expected) << i;
    positive += expected > 0.0f ? 1 : 0;
  }
  EXPECT_GT(positive, 50000);
}

// A Lambertian surface, and smooth glass, whose reflection has one direction.
TEST(ReflectionSamplingStatistical, SurfacesWithoutMicrofacetsHaveNone) {
  BsdfParameters matte{.base_color = Rgb(0.5f), .metallic = 0.0f, .specular = 0.0f};
  EXPECT_FALSE(SurfaceBsdf(matte, nullptr, V3f(0, 0, 1)).has_microfacets());
  BsdfParameters glass{.base_color = Rgb(1.0f), .metallic = 0.0f, .roughness = 0.0f};
  LayerParameters layers;
  layers.transmission = 1.0f;
  EXPECT_FALSE(SurfaceBsdf(glass, &layers, V3f(0, 0, 1)).has_microfacets());
  layers.clearcoat = 1.0f;
  EXPECT_TRUE(SurfaceBsdf(glass, &layers, V3f(0, 0, 1)).has_microfacets());
}

} // namespace
} // namespace kindling
