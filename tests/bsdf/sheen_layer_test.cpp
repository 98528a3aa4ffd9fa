// Layering of the sheen: the base is scaled by the greater albedo of both directions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/layered_bsdf.h"

#include "tests/bsdf/reciprocity.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::describe;
using test::expect_reciprocal;
using test::LayeredMaterial;
using test::Random;
using test::random_direction;
using test::random_material;
using test::view;

// On thin walls: beyond the boundary of a volume there is no sheen, so refraction differs by side.
TEST(SheenLayer, BaseBelowIsReciprocal) {
  Random random(12);
  for (int i = 0; i < 300; ++i) {
    LayeredMaterial m = random_material(random, 0.0f);
    m.layers.clearcoat = m.layers.transmission = 0.0f;
    m.layers.thin_walled = true;
    if (i % 10 != 0) m.layers.sheen_color = Rgb(0.1f) + m.layers.sheen_color * 0.9f;
    expect_reciprocal(m, random, "base below sheen");
  }
}

// KHR_materials_sheen, "Albedo-scaling technique".
TEST(SheenLayer, ScalesBaseByGreaterAlbedoOfBothDirections) {
  Random random(13);
  for (int i = 0; i < 2000; ++i) {
    LayeredMaterial m = random_material(random, 0.0f);
    m.layers.clearcoat = 0.0f;
    const V3f wo = random_direction(random);
    const V3f wi = (random.next_1d() < 0.3f ? -1.0f : 1.0f) * random_direction(random);
    LayeredMaterial bare = m;
    bare.layers.sheen_color = Rgb(0.0f);
    const float roughness = std::max(m.layers.sheen_roughness, kMinSheenRoughness);
    const SheenLobe sheen(roughness, wo);
    const float e_o = sheen.albedo(), e_i = SheenLobe(roughness, V3f(wi.x, wi.y, std::abs(wi.z))).albedo();
    const float strongest = max_component(m.layers.sheen_color);
    const bool into_volume = wi.z < 0.0f && !m.layers.thin_walled;
    const float scale = into_volume ? 1.0f - strongest * e_o : std::min(1.0f - strongest * e_o, 1.0f - strongest * e_i);
    Rgb expected = LayeredBsdf(bare.base, bare.layers, wo).eval(wi).value * scale;
    if (wi.z > 0.0f) expected += m.layers.sheen_color * sheen.eval(wi).value;
    const Rgb value = LayeredBsdf(m.base, m.layers, wo).eval(wi).value;
    ASSERT_LT((value - expected).length(), 1e-5f + 1e-4f * expected.length()) << describe(m, wo.z) << " wi " << wi;
  }
}

// Lambert below the sheen: what is lost where light grazes is lost, nothing else.
TEST(SheenLayer, AlbedoOfLambertBelowIsExact) {
  for (const float roughness : {0.1f, 0.3f, 0.6f, 1.0f}) {
    for (const float mu : {1.0f, 0.6f, 0.2f, 0.03f}) {
      BsdfParameters p;
      p.base_color = {1.0f, 0.5f, 0.0f};
      p.metallic = p.specular = 0.0f;
      LayerParameters layers;
      layers.sheen_color = {0.8f, 0.2f, 0.6f};
      layers.sheen_roughness = roughness;
      const LayeredBsdf bsdf(p, layers, view(mu, 0.1f));
      double sum[3] = {}; // by a quadrature of the base alone
      constexpr int kSteps = 20000;
      const SheenLobe sheen(roughness, view(mu, 0.1f));
      for (int i = 0; i < kSteps; ++i) {
        const float mu_i = (static_cast<float>(i) + 0.5f) / kSteps;
        const V3f wi = view(mu_i, 0.4f);
        const Rgb base = bsdf.eval(wi).value - layers.sheen_color * sheen.eval(wi).value;
        for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(base[c] * 2.0f * kPi / kSteps);
      }
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(static_cast<double>(bsdf.albedo()[c]),
                    sum[c] + static_cast<double>(layers.sheen_color[c] * sheen.albedo()), 2e-3)
            << roughness << " " << mu << " " << c;
      }
    }
  }
}

} // namespace
} // namespace kindling
