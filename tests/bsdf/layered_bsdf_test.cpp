// Tests of exact properties of the layered BSDF.
// The plain model, reciprocity, agreement of eval and sample, opaque layers, invalid input.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/layered_bsdf.h"
#include "renderer/bsdf/thin_film.h"

#include "tests/bsdf/reciprocity.h"

#include <gtest/gtest.h>

#include <limits>

namespace kindling {
namespace {

using test::describe;
using test::expect_reciprocal;
using test::LayeredMaterial;
using test::Random;
using test::random_direction;
using test::random_material;
using test::view;

TEST(LayeredBsdf, EqualsGltfBsdfWithoutLayers) {
  Random random(1);
  for (int i = 0; i < 50000; ++i) {
    BsdfParameters p = random_material(random, 0.0f).base;
    if (i % 7 == 0) p.metallic = p.specular = 0.0f;
    const V3f wo = random_direction(random);
    const V3f wi = random_direction(random);
    const GltfBsdf plain(p, wo);
    const LayeredBsdf layered(p, {}, wo);
    const BsdfEval a = plain.eval(wi);
    const BsdfEval b = layered.eval(wi);
    ASSERT_LT((a.value - b.value).length(), 1e-5f * a.value.length() + 1e-12f) << i;
    ASSERT_NEAR(a.pdf, b.pdf, 1e-5f * a.pdf + 1e-6f * wi.z)
        << i; // the plain model keeps a probability of 1e-6 for invisible reflections
    ASSERT_LT((plain.albedo() - layered.albedo()).length(), 1e-5f) << i;
    ASSERT_NEAR(plain.glossy_probability(), layered.cosine_begin(), 2e-6f) << i;
    ASSERT_NEAR(plain.smooth_share(0.5f), layered.smooth_share(0.5f), 2e-6f) << i;
    ASSERT_EQ(layered.straight_transmittance(), Rgb(0.0f));
    ASSERT_EQ(layered.coat_transmittance(), 1.0f);
    const float u_lobe = random.next_1d();
    const V2f u = random.next_2d();
    if (std::abs(u_lobe - plain.glossy_probability()) < 1e-5f) continue;
    const auto s = plain.sample(u_lobe, u);
    const auto t = layered.sample(u_lobe, u);
    ASSERT_EQ(s.has_value(), t.has_value()) << i;
    if (!s) continue;
    ASSERT_EQ(s->lobe, t->lobe);
    ASSERT_LT((s->wi - t->wi).length(), 1e-4f) << i;
    ASSERT_LT((s->weight - t->weight).length(), 1e-3f * s->weight.length() + 1e-6f) << i;
  }
}

TEST(LayeredBsdf, SmoothLobesHaveTheirShareOfTheAlbedo) {
  const V3f wo(0.6f, 0.0f, 0.8f);
  const BsdfParameters rough_metal{.roughness = 0.8f}, smooth_metal{.roughness = 0.2f};
  EXPECT_EQ(LayeredBsdf(rough_metal, {}, wo).smooth_share(0.075f), 0.0f);
  EXPECT_GT(LayeredBsdf(smooth_metal, {}, wo).smooth_share(0.075f), 0.99f);
  EXPECT_EQ(LayeredBsdf(smooth_metal, {}, wo).smooth_share(0.03f), 0.0f); // alpha .04
  LayerParameters stretched;
  stretched.anisotropy = 1.0f; // the larger alpha counts
  EXPECT_EQ(LayeredBsdf(smooth_metal, stretched, wo).smooth_share(0.075f), 0.0f);
  LayerParameters coat;
  coat.clearcoat = 1.0f; // reflects 4 to 5 % of a white ground's light
  const float coat_share = LayeredBsdf(rough_metal, coat, wo).smooth_share(0.075f);
  EXPECT_GT(coat_share, 0.03f);
  EXPECT_LT(coat_share, 0.07f);
  LayerParameters glass;
  glass.transmission = 1.0f;
  EXPECT_EQ(LayeredBsdf({.metallic = 0.0f, .roughness = 0.0f}, glass, wo).smooth_share(0.075f), 1.0f);
  EXPECT_EQ(LayeredBsdf({.metallic = 0.0f, .roughness = 0.6f}, glass, wo).smooth_share(0.075f), 0.0f);
  EXPECT_EQ(LayeredBsdf({.metallic = 0.0f, .specular = 0.0f}, {}, wo).smooth_share(1.0f), 0.0f) << "Lambert";
}

TEST(LayeredBsdf, OpaqueBaseAndDiffuseTransmissionAreReciprocal) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    LayeredMaterial m = random_material(random, 0.0f);
    m.layers.clearcoat = m.layers.transmission = 0.0f;
    m.layers.sheen_color = Rgb(0.0f);
    expect_reciprocal(m, random, "base");
  }
}

TEST(LayeredBsdf, SingleLayersAreReciprocal) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    LayeredMaterial m = random_material(random, 0.0f);
    m.base.base_color = Rgb(0.0f);
    m.base.metallic = m.base.specular = m.layers.transmission = m.layers.diffuse_transmission = 0.0f;
    const bool coat = i % 2 == 0;
    m.layers.clearcoat_normal = {0.0f, 0.0f, 1.0f}; // else the two cosines differ
    (coat ? m.layers.sheen_color : m.layers.clearcoat_normal) = coat ? Rgb(0.0f) : V3f(0.0f, 0.0f, 1.0f);
    if (!coat) m.layers.clearcoat = 0.0f;
    expect_reciprocal(m, random, coat ? "coat" : "sheen");
  }
}

TEST(LayeredBsdf, SampleAgreesWithEval) {
  Random random(4);
  int below = 0;
  for (int i = 0; i < 100000; ++i) {
    const LayeredMaterial m = random_material(random, 0.0f);
    const V3f wo = random_direction(random);
    const LayeredBsdf bsdf(m.base, m.layers, wo);
    const float u_lobe = random.next_1d();
    const auto s = bsdf.sample(u_lobe, random.next_2d());
    if (!s) continue;
    ASSERT_TRUE(is_finite(s->weight) && std::isfinite(s->pdf) && min_component(s->weight) >= 0.0f)
        << i << describe(m, wo.z);
    ASSERT_NEAR(s->wi.length(), 1.0f, 3e-6f);
    ASSERT_EQ(s->lobe == Lobe::transmission, s->wi.z < 0.0f);
    if (u_lobe >= bsdf.cosine_begin()) {
      ASSERT_EQ(s->lobe, Lobe::diffuse);
    }
    below += s->wi.z < 0.0f ? 1 : 0;
    if (s->pdf == 0.0f) continue; // delta
    // sample() of glass uses the density of the microfacet, which eval() cannot recover from the
    // rounded wi of a narrow lobe.
    const bool glass = m.layers.transmission > 0.0f;
    if (glass && (m.base.roughness < 0.3f || m.base.ior < 1.2f)) continue;
    const float tolerance = glass ? 2e-2f : 1e-4f;
    const BsdfEval e = bsdf.eval(s->wi);
    ASSERT_NEAR(s->pdf, e.pdf, tolerance * e.pdf) << i << describe(m, wo.z);
    ASSERT_LT((s->weight - e.value / e.pdf).length(), tolerance * std::max(1.0f, s->weight.length()))
        << i << describe(m, wo.z);
  }
  EXPECT_GT(below, 5000);
}

// KHR_materials_clearcoat: F of ior 1.5 at normal incidence, on black and on white.
TEST(LayeredBsdf, CoatReflectsFourPercentAndAttenuatesBase) {
  BsdfParameters black;
  black.base_color = Rgb(0.0f);
  black.metallic = black.specular = 0.0f;
  LayerParameters layers;
  layers.clearcoat = 1.0f;
  const V3f n(0.0f, 0.0f, 1.0f);
  EXPECT_NEAR(LayeredBsdf(black, layers, n).albedo().x, 0.04f, 1e-4f);
  EXPECT_NEAR(LayeredBsdf(black, layers, n).coat_transmittance(), 0.96f, 1e-4f);
  layers.clearcoat = 0.5f;
  EXPECT_NEAR(LayeredBsdf(black, layers, n).albedo().x, 0.02f, 1e-4f);
  BsdfParameters gray = black;
  gray.base_color = Rgb(0.5f);
  EXPECT_NEAR(LayeredBsdf(gray, layers, n).albedo().x, 0.02f + 0.98f * 0.5f, 1e-4f);
  // Along its own normal, independent of the base's normal.
  layers.clearcoat = 1.0f;
  layers.clearcoat_normal = view(0.7f, 0.2f);
  EXPECT_NEAR(LayeredBsdf(black, layers, layers.clearcoat_normal).albedo().x, 0.04f, 1e-4f);
  // The coat does not reflect light from below its horizon.
  const V3f below_coat = view(0.05f, 0.7f);
  ASSERT_LT(below_coat.dot(layers.clearcoat_normal), 0.0f);
  EXPECT_EQ(LayeredBsdf(black, layers, n).eval(below_coat).value, Rgb(0.0f));
  EXPECT_GT(LayeredBsdf(black, layers, n).eval(view(0.5f, 0.2f)).value.x, 0.0f);
}

// Straight transmission and blurred transmission meet at one roughness, which belongs to the
// former.
TEST(LayeredBsdf, ThinWallsAreStraightUpToRoughnessLimit) {
  BsdfParameters p;
  p.base_color = Rgb(1.0f);
  p.metallic = 0.0f;
  LayerParameters layers;
  layers.transmission = 1.0f;
  const V3f wo = view(0.8f, 0.3f);
  for (const float roughness : {0.0f, kStraightRoughness, std::nextafter(kStraightRoughness, 1.0f), 0.1f}) {
    p.roughness = roughness;
    const LayeredBsdf bsdf(p, layers, wo);
    const bool straight = roughness <= kStraightRoughness;
    EXPECT_EQ(bsdf.straight_transmittance().x > 0.9f, straight) << roughness;
    EXPECT_EQ(bsdf.eval(-wo).pdf > 0.0f, !straight) << roughness;
  }
}

// KHR_materials_diffuse_transmission: without reflection it is exactly Lambert on both sides.
TEST(LayeredBsdf, DiffuseTransmissionIsLambertBelow) {
  BsdfParameters p;
  p.base_color = {0.8f, 0.6f, 0.4f};
  p.metallic = p.specular = 0.0f;
  LayerParameters layers;
  layers.diffuse_transmission = 0.25f;
  layers.diffuse_transmission_color = {0.4f, 0.8f, 1.0f};
  const LayeredBsdf bsdf(p, layers, view(0.3f, 0.1f));
  const BsdfEval above = bsdf.eval(view(0.7f, 0.9f));
  const BsdfEval below = bsdf.eval(-view(0.7f, 0.4f));
  EXPECT_LT((above.value - p.base_color * (0.75f * 0.7f * kInvPi)).length(), 1e-6f);
  EXPECT_LT((below.value - layers.diffuse_transmission_color * (0.25f * 0.7f * kInvPi)).length(), 1e-6f);
  EXPECT_NEAR(above.pdf + below.pdf, 0.7f * kInvPi, 1e-6f);
}

// A mirror with a film has the film's own color, at any angle: on metal, and on a dielectric
// without its body. Under a clear coat the film is lit from within the coat.
TEST(LayeredBsdf, MirrorHasFilmColor) {
  BsdfParameters p;
  p.base_color = {0.9f, 0.5f, 0.2f};
  p.roughness = 0.0f;
  LayerParameters layers;
  layers.iridescence_ior = 1.6f;
  Random random(6);
  for (const float metallic : {0.0f, 1.0f}) {
    p.metallic = metallic;
    if (metallic == 0.0f) p.base_color = Rgb(0.0f);
    const Rgb f0 = metallic == 0.0f ? Rgb(0.04f) : p.base_color;
    for (const float amount : {1.0f, 0.4f}) {
      for (const float thickness : {120.0f, 350.0f, 800.0f}) {
        for (const float mu : {0.95f, 0.6f, 0.3f}) {
          layers.iridescence = amount;
          layers.iridescence_thickness_nm = thickness;
          const Rgb film = thin_film_fresnel(mu, 1.0f, 1.6f, f0, thickness);
          const Rgb expected = lerp(f0 + (Rgb(1.0f) - f0) * pow5(1.0f - mu), film, amount);
          const LayeredBsdf bsdf(p, layers, view(mu, 0.4f));
          Rgb mean(0.0f);
          constexpr int kSamples = 2000;
          for (int i = 0; i < kSamples; ++i) {
            const float u_lobe = 0.5f * random.next_1d() * bsdf.cosine_begin();
            const auto s = bsdf.sample(u_lobe, random.next_2d());
            if (s) mean += s->weight * (bsdf.cosine_begin() / kSamples);
          }
          EXPECT_LT((mean - expected).length(), 3e-3f) << metallic << " " << amount << " " << thickness << " " << mu;
          EXPECT_LT((bsdf.albedo() - expected).length(), 6e-3f)
              << metallic << " " << amount << " " << thickness << " " << mu;
        }
      }
    }
  }
  layers.iridescence = layers.clearcoat = 1.0f;
  layers.iridescence_thickness_nm = 350.0f;
  const LayeredBsdf coated(p, layers, {0.0f, 0.0f, 1.0f});
  const Rgb film = thin_film_fresnel(1.0f, 1.5f, 1.6f, p.base_color, 350.0f);
  EXPECT_LT((coated.albedo() - (Rgb(0.04f) + film * 0.96f)).length(), 2e-3f);
}

// The lobes are those of the glass, scaled by the layers above; a smooth wall transmits light in a
// straight line.
TEST(LayeredBsdf, TransmissionIsGlassBelowLayers) {
  Random random(8);
  const V3f wo = view(0.6f, 0.1f);
  for (int i = 0; i < 2000; ++i) {
    LayeredMaterial m = random_material(random, 0.1f);
    m.layers.transmission = 1.0f;
    m.layers.iridescence = 0.0f;
    m.layers.anisotropy = 0.0f;
    m.base.metallic = 0.25f;
    m.base.ior = 1.3f + random.next_1d();
    m.layers.eta = m.base.ior;
    DielectricParameters p;
    p.alpha_x = p.alpha_y = square(m.base.roughness);
    p.eta = m.layers.eta;
    p.thin_walled = m.layers.thin_walled;
    p.specular = m.base.specular;
    p.specular_color = m.base.specular_color;
    p.tint = m.base.base_color;
    const DielectricLobe glass(p, wo);
    const LayeredBsdf bsdf(m.base, m.layers, wo);
    // Below the surface there is nothing else.
    const V2f drawn = random.next_2d();
    const V3f wi = -view(0.1f + 0.9f * drawn.x, drawn.y);
    const Rgb expected = glass.eval(wi).value * 0.75f;
    const Rgb layered = bsdf.eval(wi).value;
    LayerParameters top = m.layers;
    top.transmission = 0.0f;
    BsdfParameters white;
    white.metallic = white.specular = 0.0f;
    LayerParameters bare = top;
    bare.diffuse_transmission = 1.0f;
    bare.diffuse_transmission_color = Rgb(1.0f);
    const float layers = LayeredBsdf(white, bare, wo).eval(wi).value.x * kPi / -wi.z;
    ASSERT_LT((layered - expected * layers).length(), 1e-5f + 1e-4f * expected.length()) << describe(m, wo.z);
  }
  BsdfParameters thin_wall;
  thin_wall.base_color = {0.9f, 0.8f, 0.7f};
  thin_wall.metallic = 0.0f;
  thin_wall.roughness = 0.0f;
  LayerParameters layers;
  layers.transmission = 0.8f;
  const Rgb straight = LayeredBsdf(thin_wall, layers, {0.0f, 0.0f, 1.0f}).straight_transmittance();
  EXPECT_LT((straight - thin_wall.base_color * (0.8f * 0.96f)).length(), 1e-4f);
  layers.clearcoat = 1.0f;
  const Rgb coated = LayeredBsdf(thin_wall, layers, {0.0f, 0.0f, 1.0f}).straight_transmittance();
  EXPECT_LT((coated - straight * 0.96f).length(), 1e-4f);
  layers.thin_walled = false;
  EXPECT_EQ(LayeredBsdf(thin_wall, layers, {0.0f, 0.0f, 1.0f}).straight_transmittance(), Rgb(0.0f));
}

TEST(LayeredBsdf, GrazingInvertedAndInvalidInputIsFinite) {
  Random random(5);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const V3f views[] = {{1, 0, 0}, {0, 1, 1e-30f}, {1, 0, 1e-6f}, {0.6f, 0, -0.8f}, {0, 0, -1}, {0, 0, 1}};
  const V3f lights[] = {{-1, 0, 1e-30f}, {1, 0, 1e-7f},  {0, 0, 1}, {0, -1, 1e-4f},
                        {0, 0, -1},      {1, 0, -1e-6f}, {1, 0, 0}};
  for (int i = 0; i < 3000; ++i) {
    LayeredMaterial m = random_material(random, 0.0f);
    LayerParameters& l = m.layers;
    float* const fields[] = {&m.base.metallic,
                             &m.base.roughness,
                             &m.base.specular,
                             &m.base.base_color.x,
                             &m.base.specular_color.y,
                             &l.clearcoat,
                             &l.clearcoat_roughness,
                             &l.clearcoat_normal.z,
                             &l.sheen_color.y,
                             &l.sheen_roughness,
                             &l.anisotropy,
                             &l.iridescence,
                             &l.iridescence_ior,
                             &l.iridescence_thickness_nm,
                             &l.transmission,
                             &l.eta,
                             &l.diffuse_transmission,
                             &l.diffuse_transmission_color.z};
    constexpr float kBad[] = {kNan, -3.0f, 7.0f, kInfinity, -kInfinity};
    if (i % 3 == 0) *fields[random.next_u64() % std::size(fields)] = kBad[random.next_u64() % std::size(kBad)];
    for (const V3f& wo : views) {
      const LayeredBsdf bsdf(m.base, m.layers, wo);
      const Rgb albedo = bsdf.albedo();
      ASSERT_TRUE(is_finite(albedo) && min_component(albedo) >= 0.0f && max_component(albedo) <= 1.0f)
          << describe(m, wo.z);
      const Rgb straight = bsdf.straight_transmittance();
      ASSERT_TRUE(is_finite(straight) && min_component(straight) >= 0.0f && max_component(straight) <= 1.0f)
          << describe(m, wo.z);
      for (const V3f& wi : lights) {
        const BsdfEval e = bsdf.eval(wi);
        ASSERT_TRUE(is_finite(e.value) && std::isfinite(e.pdf) && min_component(e.value) >= 0.0f && e.pdf >= 0.0f)
            << describe(m, wo.z) << " wi " << wi;
      }
      for (const float u : {0.0f, 0.5f, kOneMinusEpsilon}) {
        const float u_lobe = random.next_1d();
        const auto s = bsdf.sample(u_lobe, {random.next_1d(), u});
        if (s) {
          ASSERT_TRUE(is_finite(s->weight) && std::isfinite(s->pdf) && is_finite(s->wi) &&
                      min_component(s->weight) >= 0.0f)
              << describe(m, wo.z);
        }
      }
    }
  }
}

TEST(LayeredBsdf, BlackMaterialsAbsorb) {
  BsdfParameters p;
  p.base_color = Rgb(0.0f);
  p.metallic = p.specular = 0.0f;
  LayerParameters layers;
  layers.diffuse_transmission = 0.5f;
  layers.diffuse_transmission_color = Rgb(0.0f);
  EXPECT_FALSE(LayeredBsdf(p, layers, {0, 0, 1}).sample(0.5f, {0.5f, 0.5f}));
  EXPECT_EQ(LayeredBsdf(p, layers, {0, 0, 1}).albedo(), Rgb(0.0f));
}

} // namespace
} // namespace kindling
