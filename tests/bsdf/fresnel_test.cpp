// Tests of Fresnel's equations, refraction and KHR_materials_specular.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/fresnel.h"

#include "tests/sampling/random.h"

#include "renderer/sampling/warp.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Random;

TEST(Fresnel, MatchesKnownValues) {
  EXPECT_FLOAT_EQ(dielectric_f0(1.5f), 0.04f);
  EXPECT_FLOAT_EQ(dielectric_fresnel(1.0f, 1.5f), 0.04f);
  EXPECT_FLOAT_EQ(dielectric_fresnel(1.0f, 1.0f / 1.5f), 0.04f);
  EXPECT_NEAR(dielectric_fresnel(0.0f, 1.5f), 1.0f, 1e-6f);
  EXPECT_NEAR(dielectric_fresnel(0.3f, 1.0f), 0.0f, 1e-12f);
  // Hecht, "Optics": at 60 degrees on glass of 1.5, R_s = 0.1766 and R_p = 0.0018.
  EXPECT_NEAR(dielectric_fresnel(0.5f, 1.5f), 0.5f * (0.17665f + 0.00180f), 1e-4f);
  // Brewster's angle: only the perpendicular half remains, ((n^2 - 1) / (n^2 + 1))^2 / 2.
  const float brewster = 1.0f / std::sqrt(1.0f + 1.5f * 1.5f);
  EXPECT_NEAR(dielectric_fresnel(brewster, 1.5f), 0.5f * square(1.25f / 3.25f), 1e-6f);
  EXPECT_FLOAT_EQ(schlick_fresnel(0.04f, 1.0f, 1.0f), 0.04f);
  EXPECT_FLOAT_EQ(schlick_fresnel(0.04f, 0.7f, 0.0f), 0.7f);
  EXPECT_NEAR(schlick_fresnel(0.04f, 1.0f, 0.5f), 0.04f + 0.96f / 32.0f, 1e-6f);
}

TEST(Fresnel, TotalReflectionStartsAtCriticalAngle) {
  const float critical = std::sqrt(1.0f - 1.0f / (1.5f * 1.5f)); // cosine inside glass
  EXPECT_EQ(dielectric_fresnel(critical - 1e-4f, 1.0f / 1.5f), 1.0f);
  EXPECT_EQ(dielectric_fresnel(0.01f, 1.0f / 1.5f), 1.0f);
  EXPECT_LT(dielectric_fresnel(critical + 1e-3f, 1.0f / 1.5f), 0.9f);
  EXPECT_LT(refracted_cosine(critical - 1e-4f, 1.0f / 1.5f), 0.0f);
}

TEST(Fresnel, IsSymmetric) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const float eta = 1.0f + 1.5f * random.next_1d();
    const float cos_i = random.next_1d();
    const float cos_t = refracted_cosine(cos_i, eta);
    ASSERT_GT(cos_t, 0.0f);
    ASSERT_NEAR(dielectric_fresnel(cos_i, cos_t, eta), dielectric_fresnel(cos_t, cos_i, 1.0f / eta), 2e-6f);
    // Computed from the cosine alone it is worse conditioned at grazing angles on the thinner side.
    ASSERT_NEAR(dielectric_fresnel(cos_i, eta), dielectric_fresnel(cos_t, 1.0f / eta), cos_i > 0.1f ? 2e-5f : 5e-3f);
  }
}

TEST(Fresnel, RefractionObeysSnellsLaw) {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const float eta = 0.4f + 2.0f * random.next_1d();
    const V3f n = sample_uniform_sphere(random.next_2d());
    V3f w = sample_uniform_sphere(random.next_2d());
    if (w.dot(n) < 0.0f) w = -w;
    const float cos_t = refracted_cosine(w.dot(n), eta);
    if (cos_t < 0.0f) {
      ASSERT_GE(w.cross(n).length(), eta * (1.0f - 1e-5f));
      continue;
    }
    const V3f t = refracted_direction(w, n, cos_t, eta);
    ASSERT_NEAR(t.length(), 1.0f, 1e-6f);
    ASSERT_NEAR(-t.dot(n), cos_t, 1e-5f);
    ASSERT_LT((w + t * eta).cross(n).length(), 1e-5f); // coplanar, and n1 sin = n2 sin
  }
}

TEST(Fresnel, SpecularRangesFromF0ToF90) {
  const Rgb color(2.0f, 1.0f, 0.0f);
  for (const float eta : {1.5f, 1.0f / 1.5f}) {
    const SpecularFresnel f(eta, 0.5f, color);
    const Rgb normal = f(dielectric_fresnel(1.0f, eta));
    EXPECT_NEAR(normal.x, 0.04f, 1e-6f);
    EXPECT_NEAR(normal.y, 0.02f, 1e-6f);
    EXPECT_NEAR(normal.z, 0.0f, 1e-6f);
    const Rgb grazing = f(1.0f);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(grazing[c], 0.5f, 1e-6f);
  }
  const SpecularFresnel plain(1.5f, 1.0f, Rgb(1.0f));
  const SpecularFresnel mirror(1.5f, 1.0f, Rgb(1000.0f)); // clamped to 1
  const SpecularFresnel none(1.5f, 0.0f, Rgb(1.0f));
  for (const float reflectance : {0.04f, 0.1f, 0.5f, 1.0f}) {
    EXPECT_NEAR(plain(reflectance).x, reflectance, 1e-6f);
    EXPECT_NEAR(mirror(reflectance).x, 1.0f, 1e-6f);
    EXPECT_EQ(none(reflectance), Rgb(0.0f));
  }
}

} // namespace
} // namespace kindling
