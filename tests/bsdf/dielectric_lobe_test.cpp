// Tests of exact properties of the dielectric lobe.
// Reciprocity, deltas, total reflection, thin walls, agreement of eval and sample, invalid input.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dielectric_lobe.h"

#include "tests/sampling/random.h"

#include "renderer/sampling/warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kindling {
namespace {

using test::Random;

V3f upwards(Random& random) {
  V3f w = sample_uniform_hemisphere(random.next_2d());
  w.z = std::max(w.z, 0.02f);
  return w.normalized();
}

DielectricParameters random_interface(Random& random) {
  DielectricParameters p;
  p.alpha_x = square(0.04f + 0.96f * random.next_1d());
  p.alpha_y = random.next_1d() < 0.5f ? p.alpha_x : square(0.04f + 0.96f * random.next_1d());
  const float eta = 1.02f + 1.4f * random.next_1d();
  p.eta = random.next_1d() < 0.5f ? eta : 1.0f / eta;
  p.thin_walled = random.next_1d() < 0.3f;
  const float s = 1.5f * random.next_1d();
  p.specular = std::min(s, 1.0f);
  p.specular_color = {2.0f * random.next_1d(), 2.0f * random.next_1d(), 2.0f * random.next_1d()};
  p.tint = {random.next_1d(), random.next_1d(), random.next_1d()};
  if (random.next_1d() < 0.2f) {
    p.iridescence = random.next_1d();
    p.film_thickness_nm = 800.0f * random.next_1d();
  }
  return p;
}

TEST(DielectricLobe, ReflectionIsReciprocalUpToCompensation) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const DielectricParameters p = random_interface(random);
    const V3f a = upwards(random);
    const V3f b = upwards(random);
    const DielectricLobe from_a(p, a);
    const DielectricLobe from_b(p, b);
    const Rgb forward = from_a.eval(b).value / (b.z * from_a.compensation());
    const Rgb backward = from_b.eval(a).value / (a.z * from_b.compensation());
    ASSERT_LT((forward - backward).length(), 1e-3f * std::max(forward.length(), 1e-5f)) << i;
  }
}

// f(a, b) / eta^2 = f(b, a): radiance is not scaled on refraction.
TEST(DielectricLobe, RefractionIsReciprocalUpToEtaSquared) {
  Random random(2);
  int compared = 0;
  for (int i = 0; i < 100000; ++i) {
    DielectricParameters p = random_interface(random);
    const V3f a = upwards(random);
    const DielectricLobe lobe(p, a);
    const auto s = lobe.sample(0.999f, random.next_2d());
    if (!s || s->wi.z > -0.02f) continue;
    const Rgb forward = lobe.eval(s->wi).value / (-s->wi.z * lobe.compensation());
    // Mirrors the direction to view it from the other side.
    const V3f b(s->wi.x, s->wi.y, -s->wi.z);
    DielectricParameters q = p;
    q.eta = 1.0f / p.eta;
    const V3f to(a.x, a.y, -a.z);
    const DielectricLobe other(q, b);
    const Rgb backward = other.eval(to).value / (a.z * other.compensation());
    const float factor = p.thin_walled ? 1.0f : p.eta * p.eta;
    ASSERT_LT((forward / factor - backward).length(), 1e-2f * std::max(backward.length(), 1e-5f))
        << i << " eta " << p.eta << " alpha " << p.alpha_x << " " << p.alpha_y << " thin " << p.thin_walled << " "
        << forward << " " << backward;
    ++compared;
  }
  EXPECT_GT(compared, 40000);
}

TEST(DielectricLobe, SampleAgreesWithEval) {
  Random random(3);
  int transmitted = 0;
  for (int i = 0; i < 200000; ++i) {
    const DielectricParameters p = random_interface(random);
    const DielectricLobe lobe(p, upwards(random));
    const float u = random.next_1d();
    const auto s = lobe.sample(u, random.next_2d());
    if (!s || lobe.is_delta()) continue;
    const BsdfEval e = lobe.eval(s->wi);
    ASSERT_EQ(s->wi.z < 0.0f, s->lobe == Lobe::transmission);
    ASSERT_NEAR(s->wi.length(), 1.0f, 3e-6f);
    ASSERT_TRUE(is_finite(s->weight) && std::isfinite(s->pdf)) << i;
    transmitted += s->wi.z < 0.0f ? 1 : 0;
    // The half vector of a refraction loses digits as eta nears 1 or wi the plane of a facet.
    if (std::abs(s->wi.z) < 1e-3f) continue;
    ASSERT_NEAR(s->pdf, e.pdf, 0.02f * e.pdf) << i << " eta " << p.eta << " alpha " << p.alpha_x << " " << p.alpha_y;
    ASSERT_LT((s->weight * s->pdf - e.value).length(), 0.02f * e.value.length() + 1e-6f) << i;
  }
  EXPECT_GT(transmitted, 60000);
}

TEST(DielectricLobe, SmoothInterfaceIsDelta) {
  DielectricParameters p;
  p.alpha_x = p.alpha_y = 0.0005f;
  p.tint = {1.0f, 0.5f, 0.25f};
  const V3f wo = V3f(0.6f, 0.0f, 0.8f);
  const DielectricLobe lobe(p, wo);
  ASSERT_TRUE(lobe.is_delta());
  const float f = dielectric_fresnel(0.8f, 1.5f);
  const auto reflected = lobe.sample(0.0f, {0.3f, 0.7f});
  const auto refracted = lobe.sample(0.9f, {0.3f, 0.7f});
  ASSERT_TRUE(reflected && refracted);
  EXPECT_EQ(reflected->pdf, 0.0f);
  EXPECT_EQ(refracted->pdf, 0.0f);
  EXPECT_LT((reflected->wi - V3f(-0.6f, 0.0f, 0.8f)).length(), 1e-6f);
  EXPECT_LT((refracted->wi - V3f(-0.4f, 0.0f, -std::sqrt(0.84f))).length(), 1e-6f);
  EXPECT_EQ(refracted->lobe, Lobe::transmission);
  EXPECT_NEAR(refracted->weight.x / refracted->weight.z, 4.0f, 1e-5f);
  EXPECT_NEAR(lobe.reflected_albedo().x, f, 1e-6f);
  EXPECT_NEAR(lobe.transmitted_albedo().y, 0.5f * (1.0f - f), 1e-6f);
  EXPECT_EQ(lobe.eval(refracted->wi).pdf, 0.0f);
  EXPECT_EQ(lobe.eval(reflected->wi).value, Rgb(0.0f));
  // Averages over u_lobe: F and tint (1 - F).
  Rgb up(0.0f), down(0.0f);
  for (int i = 0; i < 10000; ++i) {
    const auto s = lobe.sample((static_cast<float>(i) + 0.5f) / 10000.0f, {0.5f, 0.5f});
    (s->wi.z > 0.0f ? up : down) += s->weight * 1e-4f;
  }
  EXPECT_NEAR(up.x, f, 2e-4f);
  EXPECT_NEAR(down.x, 1.0f - f, 2e-4f);
  EXPECT_NEAR(down.z, 0.25f * (1.0f - f), 2e-4f);
}

// Odds change how often a smooth interface reflects, and nothing else.
TEST(DielectricLobe, ReflectionOddsChangeNoMean) {
  const float f = dielectric_fresnel(0.8f, 1.5f);
  DielectricParameters p;
  p.alpha_x = p.alpha_y = 0.0005f;
  p.tint = {1.0f, 0.5f, 0.25f};
  constexpr int kDraws = 100000;
  for (const float odds : {0.1f, 1.0f, 3.0f, 1e6f}) {
    p.reflection_odds = odds;
    const DielectricLobe lobe(p, V3f(0.6f, 0.0f, 0.8f));
    Imath::V3d up(0.0), down(0.0);
    int reflected = 0;
    for (int i = 0; i < kDraws; ++i) {
      const auto s = lobe.sample((static_cast<float>(i) + 0.5f) / kDraws, {0.5f, 0.5f});
      reflected += s->wi.z > 0.0f ? 1 : 0;
      (s->wi.z > 0.0f ? up : down) += Imath::V3d(s->weight) / kDraws;
    }
    // Without odds by luminance, of which the tint passes 0.2126 + 0.5 * 0.7152 + 0.25 * 0.0722.
    const float share = f / (f + 0.58825f * (1.0f - f));
    const float expected = odds <= 1.0f ? share : std::min(0.25f, odds * share / (odds * share + 1.0f - share));
    EXPECT_NEAR(static_cast<float>(reflected) / kDraws, expected, 2.0f / kDraws) << odds;
    EXPECT_NEAR(lobe.reflection_probability({0.5f, 0.5f}), expected, 1e-5f) << odds;
    // A draw more or less of a side, and the rounding of weights.
    EXPECT_NEAR(up.x, f, f * (2.0f / expected / kDraws + 1e-5f)) << odds;
    EXPECT_NEAR(down.z, 0.25f * (1.0f - f), 0.25f * (1.0f - f) * (4.0f / kDraws + 1e-5f)) << odds;
  }
}

TEST(DielectricLobe, TotalInternalReflectionReflectsAll) {
  for (const float roughness : {0.0f, 0.1f}) {
    DielectricParameters p;
    p.alpha_x = p.alpha_y = square(roughness);
    p.eta = 1.0f / 1.5f;
    p.specular = 0.0f; // total reflection only
    p.tint = Rgb(0.0f);
    const float cos_o = roughness > 0.0f ? 0.3f : 0.7f; // the critical angle has 0.745
    const DielectricLobe lobe(p, V3f(std::sqrt(1.0f - cos_o * cos_o), 0.0f, cos_o));
    Random random(4);
    double sum = 0.0;
    constexpr int kSamples = 20000;
    for (int i = 0; i < kSamples; ++i) {
      const float u = random.next_1d();
      const auto s = lobe.sample(u, random.next_2d());
      if (!s) continue;
      ASSERT_GT(s->wi.z, 0.0f);
      sum += static_cast<double>(s->weight.x) / kSamples;
    }
    EXPECT_NEAR(sum, 1.0, roughness > 0.0f ? 5e-3 : 1e-6);
    EXPECT_NEAR(lobe.reflected_albedo().x, 1.0f, 0.02f);
  }
}

TEST(DielectricLobe, ZeroSpecularHasNoReflection) {
  DielectricParameters p;
  p.specular = 0.0f;
  for (const float alpha : {0.0f, 0.2f}) {
    p.alpha_x = p.alpha_y = alpha;
    const DielectricLobe lobe(p, V3f(0.6f, 0.0f, 0.8f));
    EXPECT_EQ(lobe.reflected_albedo(), Rgb(0.0f));
    EXPECT_EQ(lobe.eval({-0.6f, 0.0f, 0.8f}).value, Rgb(0.0f));
    const auto s = lobe.sample(0.0f, {0.5f, 0.1f});
    ASSERT_TRUE(s);
    EXPECT_LT(s->wi.z, 0.0f);
  }
}

// One surface of a thin wall stands for both interfaces and transmits 1 - F. A thin wall modeled as
// two such surfaces transmits (1 - F)^2, tinted twice, and (1 - F) / (1 + F) with interreflections
// between them.
TEST(DielectricLobe, ThinWallTransmittanceMatchesExtension) {
  DielectricParameters p;
  p.thin_walled = true;
  p.tint = {1.0f, 0.5f, 0.25f};
  for (const float cos_o : {1.0f, 0.7f, 0.3f}) {
    const DielectricLobe lobe(p, V3f(std::sqrt(1.0f - cos_o * cos_o), 0.0f, cos_o));
    const float f = dielectric_fresnel(cos_o, 1.5f);
    const Rgb straight = lobe.straight_transmittance();
    EXPECT_NEAR(straight.x, 1.0f - f, 1e-6f);
    EXPECT_NEAR(straight.y, 0.5f * (1.0f - f), 1e-6f);
    EXPECT_EQ(lobe.transmitted_albedo(), Rgb(0.0f));
    EXPECT_NEAR(lobe.reflected_albedo().x + straight.x, 1.0f, 1e-6f);
    // From behind, and with the inverse index.
    p.eta = 1.0f / 1.5f;
    EXPECT_NEAR(DielectricLobe(p, V3f(std::sqrt(1.0f - cos_o * cos_o), 0.0f, cos_o)).straight_transmittance().x,
                straight.x, 1e-6f);
    p.eta = 1.5f;
    // Two surfaces with ten reflections between them.
    const float r = lobe.reflected_albedo().x;
    float thin_wall = 0.0f, between = straight.x;
    for (int i = 0; i < 10; ++i) {
      thin_wall += between * straight.x;
      between *= r * r;
    }
    EXPECT_NEAR(thin_wall, (1.0f - f) / (1.0f + f), 1e-5f);
    // Sampling yields the reflection only, with the same albedo.
    Random random(5);
    double sum = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const float u = random.next_1d();
      const auto s = lobe.sample(u, random.next_2d());
      if (s) sum += static_cast<double>(s->weight.x) / 2000.0;
      ASSERT_TRUE(!s || s->wi.z > 0.0f);
    }
    EXPECT_NEAR(sum, static_cast<double>(f), 2e-3 * static_cast<double>(f) + 1e-4);
  }
}

// Values and densities above and below add up to those of a mirror with the same facets.
TEST(DielectricLobe, ThinWallTransmissionMirrorsReflection) {
  DielectricParameters p;
  p.alpha_x = 0.2f;
  p.alpha_y = 0.1f;
  p.thin_walled = true;
  p.specular = 0.8f;
  DielectricParameters mirror = p;
  mirror.specular = 1.0f;
  mirror.specular_color = Rgb(1000.0f); // F0 and F90 are 1
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    const V3f wo = upwards(random);
    const V3f up = upwards(random);
    const BsdfEval above = DielectricLobe(p, wo).eval(up);
    const BsdfEval below = DielectricLobe(p, wo).eval({up.x, up.y, -up.z});
    const BsdfEval whole = DielectricLobe(mirror, wo).eval(up);
    ASSERT_NEAR(above.value.x + below.value.x, whole.value.x, 1e-4f * whole.value.x);
    ASSERT_NEAR(above.pdf + below.pdf, whole.pdf, 1e-4f * whole.pdf);
  }
}

TEST(DielectricLobe, InvalidInputGivesFiniteValues) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const float odd[] = {0.0f, 1.0f, -1.0f, 1e-30f, 1e30f, kNan, kInfinity, 1e-4f, 0.999f};
  Random random(7);
  for (int i = 0; i < 200000; ++i) {
    const auto draw = [&](float scale) {
      const float u = random.next_1d();
      return u < 0.15f ? odd[random.next_u64() % std::size(odd)] : scale * random.next_1d();
    };
    DielectricParameters p;
    p.alpha_x = draw(1.0f);
    p.alpha_y = draw(1.0f);
    p.eta = draw(3.0f);
    p.thin_walled = random.next_1d() < 0.3f;
    p.specular = draw(1.0f);
    p.specular_color = {draw(2.0f), draw(2.0f), draw(2.0f)};
    p.tint = {draw(1.0f), draw(1.0f), draw(1.0f)};
    p.iridescence = random.next_1d() < 0.5f ? 0.0f : draw(1.0f);
    p.film_ior = draw(2.0f);
    p.film_thickness_nm = draw(500.0f);
    const V3f views[] = {{1, 0, 0}, {0, 1, 1e-30f}, {0.6f, 0, -0.8f}, {0, 0, 1}, upwards(random)};
    const DielectricLobe lobe(p, views[random.next_u64() % std::size(views)]);
    for (const Rgb& c : {lobe.reflected_albedo(), lobe.transmitted_albedo(), lobe.straight_transmittance()}) {
      ASSERT_TRUE(is_finite(c) && min_component(c) >= 0.0f && max_component(c) <= 1.0f) << i << " " << c;
    }
    const V3f lights[] = {{1, 0, 0}, {0, 0, 1}, {0, 0, -1}, {1, 0, 1e-7f}, sample_uniform_sphere(random.next_2d())};
    const BsdfEval e = lobe.eval(lights[random.next_u64() % std::size(lights)]);
    ASSERT_TRUE(is_finite(e.value) && std::isfinite(e.pdf) && min_component(e.value) >= 0.0f && e.pdf >= 0.0f) << i;
    const float ends[] = {0.0f, 0.5f, kOneMinusEpsilon};
    const float u_lobe = ends[random.next_u64() % 3];
    const auto s = lobe.sample(u_lobe, {random.next_1d(), ends[random.next_u64() % 3]});
    if (!s) continue;
    ASSERT_TRUE(is_finite(s->weight) && std::isfinite(s->pdf) && is_finite(s->wi) && min_component(s->weight) >= 0.0f)
        << i << " alpha " << p.alpha_x << " " << p.alpha_y << " eta " << p.eta << " specular " << p.specular << " "
        << p.specular_color << " thin " << p.thin_walled << " film " << p.iridescence << " weight " << s->weight
        << " pdf " << s->pdf << " wi " << s->wi;
  }
}

} // namespace
} // namespace kindling
