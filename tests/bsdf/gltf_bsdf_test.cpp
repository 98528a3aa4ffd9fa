// Tests of exact properties of the glTF BSDF.
// Lambert, reciprocity, known values, agreement of eval and sample, invalid input.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/gltf_bsdf.h"

#include "tests/bsdf/layered_materials.h"
#include "tests/sampling/random.h"

#include "renderer/sampling/warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kindling {
namespace {

using test::Random;
using test::random_direction;

BsdfParameters random_parameters(Random& random) {
  BsdfParameters p;
  p.base_color = {random.next_1d(), random.next_1d(), random.next_1d()};
  // The ends of the ranges are as frequent as the interior.
  const auto pick = [&] {
    const float u = 2.0f * random.next_1d() - 0.5f;
    return std::min(std::max(u, 0.0f), 1.0f);
  };
  p.metallic = pick();
  p.roughness = pick();
  p.specular = pick();
  p.ior = 1.0f + 2.0f * pick();
  p.specular_color = {2.0f * random.next_1d(), 2.0f * random.next_1d(), 2.0f * random.next_1d()};
  return p;
}

TEST(GltfBsdf, IsExactlyLambertWithoutReflection) {
  BsdfParameters p;
  p.base_color = {0.2f, 0.5f, 0.9f};
  p.metallic = 0.0f;
  p.specular = 0.0f;
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    p.roughness = random.next_1d();
    const GltfBsdf bsdf(p, random_direction(random));
    const V3f wi = random_direction(random);
    const BsdfEval e = bsdf.eval(wi);
    EXPECT_EQ(e.value, p.base_color * kInvPi * wi.z);
    EXPECT_EQ(e.pdf, wi.z * kInvPi);
    EXPECT_EQ(bsdf.albedo(), p.base_color);
    const float u_lobe = random.next_1d();
    const auto s = bsdf.sample(u_lobe, random.next_2d());
    ASSERT_TRUE(s);
    EXPECT_EQ(s->weight, p.base_color);
    EXPECT_EQ(s->pdf, cosine_hemisphere_pdf(s->wi));
    EXPECT_EQ(s->lobe, Lobe::diffuse);
  }
}

TEST(GltfBsdf, IsReciprocal) {
  Random random(2);
  for (int i = 0; i < 100000; ++i) {
    const BsdfParameters p = random_parameters(random);
    const V3f a = random_direction(random);
    const V3f b = random_direction(random);
    const Rgb forward = GltfBsdf(p, a).eval(b).value / b.z;
    const Rgb backward = GltfBsdf(p, b).eval(a).value / a.z;
    const float scale = std::max(max_component(forward), 1e-6f);
    ASSERT_LT((forward - backward).length() / scale, 2e-4f)
        << "seed 2, pair " << i << ": roughness " << p.roughness << " metallic " << p.metallic << " " << forward << " "
        << backward;
  }
}

// glTF 2.0 appendix B: at normal incidence the peak of a mirror-like metal is F D / 4 with D = 1 /
// (pi alpha^2) and G = 1.
TEST(GltfBsdf, MetalPeakMatchesFormula) {
  BsdfParameters p;
  p.base_color = {0.9f, 0.6f, 0.1f};
  p.roughness = 0.3f;
  const float alpha = 0.09f;
  const Rgb value = GltfBsdf(p, {0, 0, 1}).eval({0, 0, 1}).value;
  const float d = 1.0f / (kPi * alpha * alpha);
  EXPECT_NEAR(value.x, 0.9f * d / 4.0f, 0.9f * d / 4.0f * 2e-3f); // multiple scattering is negligible
  EXPECT_NEAR(value.z, 0.1f * d / 4.0f, 0.1f * d / 4.0f * 2e-3f);
}

TEST(GltfBsdf, DielectricReflectanceFollowsIorAndSpecular) {
  BsdfParameters p;
  p.base_color = Rgb(0.0f);
  p.metallic = 0.0f;
  p.roughness = 0.1f;
  const V3f n(0, 0, 1);
  EXPECT_NEAR(GltfBsdf(p, n).albedo().x, 0.04f, 1e-4f); // ior 1.5
  p.ior = 1.8f;
  EXPECT_NEAR(GltfBsdf(p, n).albedo().x, square(0.8f / 2.8f), 2e-4f);
  p.ior = 1.0f;
  EXPECT_NEAR(GltfBsdf(p, n).albedo().x, 0.0f, 1e-4f);
  p.ior = 0.0f; // KHR_materials_ior: full reflection
  EXPECT_NEAR(GltfBsdf(p, n).albedo().x, 1.0f, 1e-4f);
  p.ior = 1.5f;
  p.specular = 0.5f;
  p.specular_color = {2.0f, 1.0f, 0.0f};
  const Rgb albedo = GltfBsdf(p, n).albedo();
  EXPECT_NEAR(albedo.x, 0.04f, 1e-4f);
  EXPECT_NEAR(albedo.y, 0.02f, 1e-4f);
  EXPECT_NEAR(albedo.z, 0.0f, 1e-4f);
  p.specular = 1.0f;
  p.specular_color = Rgb(1000.0f); // clamped to 1
  EXPECT_NEAR(GltfBsdf(p, n).albedo().x, 1.0f, 1e-4f);
}

TEST(GltfBsdf, SampleAgreesWithEval) {
  Random random(3);
  int glossy = 0;
  for (int i = 0; i < 300000; ++i) {
    const BsdfParameters p = random_parameters(random);
    const GltfBsdf bsdf(p, random_direction(random));
    const float u_lobe = random.next_1d();
    const auto s = bsdf.sample(u_lobe, random.next_2d());
    if (!s) continue;
    glossy += s->lobe == Lobe::glossy ? 1 : 0;
    const BsdfEval e = bsdf.eval(s->wi);
    ASSERT_GT(s->wi.z, 0.0f);
    ASSERT_NEAR(s->wi.length(), 1.0f, 2e-6f);
    ASSERT_TRUE(is_finite(s->weight) && std::isfinite(s->pdf)) << i;
    ASSERT_NEAR(s->pdf, e.pdf, 1e-4f * e.pdf) << i;
    ASSERT_LT((s->weight - e.value / e.pdf).length(), 1e-4f * std::max(1.0f, s->weight.length())) << i;
  }
  EXPECT_GT(glossy, 50000);
}

TEST(GltfBsdf, IsBlackBelowHorizon) {
  const GltfBsdf bsdf({}, V3f(0.6f, 0, 0.8f));
  for (const V3f& wi : {V3f(0, 0, -1), V3f(1, 0, 0), V3f(0.6f, 0, -0.8f)}) {
    EXPECT_EQ(bsdf.eval(wi).value, Rgb(0.0f));
    EXPECT_EQ(bsdf.eval(wi).pdf, 0.0f);
  }
}

TEST(GltfBsdf, GrazingAndInvertedViewsAreFinite) {
  Random random(4);
  const V3f views[] = {{1, 0, 0}, {0, 1, 1e-30f}, {1, 0, 1e-6f}, {0.6f, 0, -0.8f}, {0, 0, -1}, {0, 0, 1}};
  const V3f lights[] = {{-1, 0, 1e-30f}, {1, 0, 1e-7f}, {0, 0, 1}, {0, -1, 1e-4f}};
  for (int i = 0; i < 2000; ++i) {
    const BsdfParameters p = random_parameters(random);
    for (const V3f& wo : views) {
      const GltfBsdf bsdf(p, wo);
      ASSERT_TRUE(is_finite(bsdf.albedo()));
      for (const V3f& wi : lights) {
        const BsdfEval e = bsdf.eval(wi);
        ASSERT_TRUE(is_finite(e.value) && std::isfinite(e.pdf) && min_component(e.value) >= 0.0f && e.pdf >= 0.0f);
      }
      for (const float u : {0.0f, 0.5f, kOneMinusEpsilon}) {
        const auto s = bsdf.sample(u, {random.next_1d(), u});
        if (s) {
          ASSERT_TRUE(is_finite(s->weight) && std::isfinite(s->pdf) && is_finite(s->wi) &&
                      min_component(s->weight) >= 0.0f);
        }
      }
    }
  }
}

TEST(GltfBsdf, ClampsParameters) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  BsdfParameters p;
  p.base_color = {2.0f, -1.0f, kNan};
  p.metallic = kNan;
  p.roughness = kNan;
  p.specular = 7.0f;
  p.specular_color = {kNan, -1.0f, kInfinity};
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    if (i == 500) p.metallic = p.roughness = 3.0f;
    const GltfBsdf bsdf(p, random_direction(random));
    const Rgb albedo = bsdf.albedo();
    ASSERT_TRUE(is_finite(albedo) && min_component(albedo) >= 0.0f && max_component(albedo) <= 1.0f);
    const float u_lobe = random.next_1d();
    const auto s = bsdf.sample(u_lobe, random.next_2d());
    if (s) {
      ASSERT_TRUE(is_finite(s->weight) && min_component(s->weight) >= 0.0f);
    }
  }
}

TEST(GltfBsdf, BlackMaterialsAbsorb) {
  BsdfParameters p;
  p.base_color = Rgb(0.0f);
  p.metallic = 0.0f;
  p.specular = 0.0f;
  EXPECT_FALSE(GltfBsdf(p, {0, 0, 1}).sample(0.5f, {0.5f, 0.5f}));
  EXPECT_EQ(GltfBsdf(p, {0, 0, 1}).albedo(), Rgb(0.0f));
}

// A white dielectric and a white metal reflect everything, at any roughness and angle.
TEST(GltfBsdf, WhiteAlbedoIsOne) {
  for (const float metallic : {0.0f, 0.3f, 1.0f}) {
    for (const float roughness : {0.0f, 0.1f, 0.4f, 0.7f, 1.0f}) {
      for (const float mu : {0.001f, 0.1f, 0.5f, 1.0f}) {
        BsdfParameters p;
        p.metallic = metallic;
        p.roughness = roughness;
        const Rgb albedo = GltfBsdf(p, {std::sqrt(1.0f - mu * mu), 0, mu}).albedo();
        EXPECT_NEAR(albedo.x, 1.0f, 1e-5f);
        EXPECT_EQ(albedo.x, albedo.y);
      }
    }
  }
}

} // namespace
} // namespace kindling
