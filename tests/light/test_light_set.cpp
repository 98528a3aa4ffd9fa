// Tests of LightSet: selection frequencies, contents of samples, and agreement of pdf functions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"
#include "tests/light/light_fixtures.h"

#include <gtest/gtest.h>

#include <array>

namespace kindling {
namespace {

using test::add_rectangle;
using test::float_image;

Emission white(float radiance, bool two_sided = false) { return {Rgb(radiance), nullptr, two_sided}; }

TEST(LightSet, EmptySetHasNoSamples) {
  const LightSet nothing{LightSetInput{}};
  EXPECT_TRUE(nothing.empty());
  EXPECT_EQ(nothing.light_count, 0u);
  EXPECT_FALSE(nothing.sample({0, 0, 0}, {0, 1, 0}, 0.5f, {0.5f, 0.5f}));
  EXPECT_EQ(nothing.pdf_environment({0, 0, 0}, {0, 1, 0}, {0, 1, 0}), 0.0f);
  EXPECT_EQ(nothing.environment_radiance(V3f(0, 1, 0)), Rgb(0.0f));
  EXPECT_FALSE(nothing.has_environment);

  LightSetInput dark;
  dark.emissions = {white(0.0f)};
  add_rectangle(dark, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0);
  dark.points.push_back({{0, 1, 0}, Rgb(0.0f), {}});
  dark.environment = std::make_shared<Environment>(Rgb(0.0f));
  const LightSet black(dark);
  EXPECT_TRUE(black.empty());
  EXPECT_EQ(black.pdf_triangle(1, {0, -1, 0}, {0, 1, 0}, {0, 1, 0}, 1.0f), 0.0f);
}

// Intersects the triangle with the sampled direction, for the density at a hit.
struct TriangleHit {
  bool hit = false;
  float distance = 0.0f;
  float u = 0.0f;
  float v = 0.0f;
};
TriangleHit intersect(const EmissiveTriangle& t, const V3f& point, const V3f& wi) {
  const V3d e1 = V3d(t.p1) - V3d(t.p0);
  const V3d e2 = V3d(t.p2) - V3d(t.p0);
  const V3d d(wi);
  const V3d s = V3d(point) - V3d(t.p0);
  const double det = e1.dot(d.cross(e2));
  const double u = s.dot(d.cross(e2)) / det;
  const double v = d.dot(s.cross(e1)) / det;
  const double distance = e2.dot(s.cross(e1)) / det;
  const bool inside = u > -1e-4 && v > -1e-4 && u + v < 1.0 + 1e-4 && distance > 0.0;
  return {inside, static_cast<float>(distance), static_cast<float>(u), static_cast<float>(v)};
}

TEST(LightSet, TriangleSamplePdfMatchesPdfTriangle) {
  LightSetInput input;
  input.emissions = {white(3.0f), white(2.0f, true)};
  input.triangles.push_back({{-1, 2, -1}, {1, 2, -1}, {0, 2, 1}, 0}); // emits downwards
  input.triangles.push_back({{4, 0, 0}, {4, 1, 0}, {4, 0, 1}, 1});
  input.triangles.push_back({{0, 0, -30}, {0.2f, 0, -30}, {0, 0.1f, -30}, 1}); // far: sampled by area
  const LightSet lights(input);
  test::Random random(1);
  constexpr int kSamples = 200'000;
  int samples = 0;
  for (int i = 0; i < kSamples; ++i) {
    const V3f point{2.0f * random.next_1d() - 1.0f, 1.5f * random.next_1d(), 2.0f * random.next_1d()};
    const float u_light = random.next_1d();
    const auto sample = lights.sample(point, {0, 1, 0}, u_light, random.next_2d());
    if (!sample) continue;
    ++samples;
    ASSERT_FALSE(sample->delta);
    ASSERT_NEAR(sample->wi.length2(), 1.0f, 1e-5f);
    int found = -1;
    for (uint32_t t = 0; t < 3; ++t) {
      const TriangleHit hit = intersect(input.triangles[t], point, sample->wi);
      if (!hit.hit || std::fabs(hit.distance - sample->distance) > 1e-3f * hit.distance) continue;
      found = static_cast<int>(t);
      const float pdf = lights.pdf_triangle(t, point, {0, 1, 0}, sample->wi, sample->distance);
      ASSERT_NEAR(pdf, sample->pdf, 1e-4f * pdf) << t;
      ASSERT_EQ(lights.emitted(t, hit.u, hit.v, sample->wi), sample->radiance);
    }
    ASSERT_GE(found, 0);
  }
  EXPECT_GT(samples, kSamples * 9 / 10);
}

TEST(LightSet, OneSidedTrianglesAreDarkBehind) {
  LightSetInput input;
  input.emissions = {white(1.0f)};
  input.triangles.push_back({{-1, 0, -1}, {1, 0, -1}, {0, 0, 1}, 0}); // its front faces down
  const LightSet lights(input);
  test::Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const float u_light = random.next_1d();
    const V2f u = random.next_2d();
    EXPECT_FALSE(lights.sample({0.1f, 0.5f, 0.0f}, {0, -1, 0}, u_light, u));
    EXPECT_TRUE(lights.sample({0.1f, -0.5f, 0.0f}, {0, 1, 0}, u_light, u));
  }
  EXPECT_FALSE(lights.sample({5.0f, 0.0f, 0.0f}, {0, 1, 0}, 0.5f, {0.5f, 0.5f})); // in its plane
  EXPECT_EQ(lights.emitted(0, 0.3f, 0.3f, {0, -1, 0}), Rgb(0.0f));
  EXPECT_EQ(lights.emitted(0, 0.3f, 0.3f, {0, 1, 0}), Rgb(1.0f));

  input.emissions = {white(1.0f, true)};
  const LightSet both(input);
  EXPECT_TRUE(both.sample({0.1f, 0.5f, 0.0f}, {0, -1, 0}, 0.5f, {0.5f, 0.5f}));
  EXPECT_EQ(both.emitted(0, 0.3f, 0.3f, {0, -1, 0}), Rgb(1.0f));
}

TEST(LightSet, DegenerateTrianglesAreNeverSelected) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  LightSetInput input;
  input.emissions = {white(1.0f, true), white(nan), white(-1.0f), white(kInfinity)};
  input.triangles.push_back({{0, 1, 0}, {0, 1, 0}, {0, 1, 0}, 0});         // a point
  input.triangles.push_back({{0, 1, 0}, {1, 1, 0}, {3, 1, 0}, 0});         // a line
  input.triangles.push_back({{nan, 1, 0}, {1, 1, 0}, {0, 1, 1}, 0});       // not a number
  input.triangles.push_back({{kInfinity, 1, 0}, {1, 1, 0}, {0, 1, 1}, 0}); // infinite
  input.triangles.push_back({{-1, 2, -1}, {1, 2, -1}, {0, 2, 1}, 1});
  input.triangles.push_back({{-1, 2, -1}, {1, 2, -1}, {0, 2, 1}, 2});
  input.triangles.push_back({{-1, 2, -1}, {1, 2, -1}, {0, 2, 1}, 3});
  input.triangles.push_back({{-1, 2, -1}, {1, 2, -1}, {0, 2, 1}, 0}); // the only valid one
  const LightSet lights(input);
  EXPECT_EQ(lights.light_count, 1u);
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const V3f point{random.next_1d(), random.next_1d(), random.next_1d()};
    const float u_light = random.next_1d();
    const auto sample = lights.sample(point, {0, 1, 0}, u_light, random.next_2d());
    ASSERT_TRUE(sample);
    ASSERT_TRUE(std::isfinite(sample->pdf) && sample->pdf > 0.0f);
    ASSERT_FLOAT_EQ(sample->pdf, lights.pdf_triangle(7, point, {0, 1, 0}, sample->wi, sample->distance));
    for (uint32_t t = 0; t < 7; ++t)
      ASSERT_EQ(lights.pdf_triangle(t, point, {0, 1, 0}, sample->wi, sample->distance), 0.0f);
  }
  // On a corner and in the plane: no sample, or at least no NaN.
  for (const V3f& point : {V3f(-1, 2, -1), V3f(0, 2, 0), V3f(10, 2, 0)}) {
    const auto sample = lights.sample(point, {0, 1, 0}, 0.5f, {0.3f, 0.3f});
    EXPECT_TRUE(!sample || (std::isfinite(sample->pdf) && is_finite(sample->wi)));
    EXPECT_TRUE(std::isfinite(lights.pdf_triangle(7, point, {0, 1, 0}, {1, 0, 0}, 1.0f)));
  }
}

TEST(LightSet, PointLightFollowsKhrLightsPunctual) {
  LightSetInput input;
  input.points.push_back({{0, 3, 0}, Rgb(18.0f, 9.0f, 0.0f), {}});
  const LightSet lights(input);
  const auto sample = lights.sample({0, 0, 0}, {0, 1, 0}, 0.5f, {0.5f, 0.5f});
  ASSERT_TRUE(sample);
  EXPECT_TRUE(sample->delta);
  EXPECT_EQ(sample->wi, V3f(0, 1, 0));
  EXPECT_FLOAT_EQ(sample->distance, 3.0f);
  EXPECT_FLOAT_EQ(sample->pdf, 1.0f);
  EXPECT_FLOAT_EQ(sample->radiance.x, 2.0f); // 18 cd at 3 m: 2 lux
  EXPECT_FALSE(lights.sample({0, 3, 0}, {0, 1, 0}, 0.5f, {0.5f, 0.5f}));

  input.points[0].range_m = 6.0f;
  const LightSet ranged(input);
  // 1 - (3 / 6)^4 = 15 / 16.
  EXPECT_FLOAT_EQ(ranged.sample({0, 0, 0}, {0, 1, 0}, 0.5f, {0.5f, 0.5f})->radiance.x, 2.0f * 15.0f / 16.0f);
  EXPECT_FALSE(ranged.sample({0, -4, 0}, {0, 1, 0}, 0.5f, {0.5f, 0.5f}));
}

TEST(LightSet, SpotLightFollowsKhrLightsPunctual) {
  LightSetInput input;
  SpotLight spot;
  spot.position = {0, 2, 0};
  spot.axis = {0, -1, 0};
  spot.intensity = Rgb(8.0f);
  spot.cos_inner = std::cos(0.3f);
  spot.cos_outer = std::cos(0.6f);
  input.spots.push_back(spot);
  const LightSet lights(input);
  const auto irradiance_over_cos = [&](float angle) {
    const auto sample = lights.sample({2.0f * std::tan(angle), 0, 0}, {0, 1, 0}, 0.5f, {0.5f, 0.5f});
    return sample ? sample->radiance.x : 0.0f;
  };
  EXPECT_FLOAT_EQ(irradiance_over_cos(0.0f), 2.0f);
  const auto expected = [&](float angle) {
    const float falloff = (std::cos(angle) - spot.cos_outer) / (spot.cos_inner - spot.cos_outer);
    return 2.0f * square(std::cos(angle)) * square(std::clamp(falloff, 0.0f, 1.0f));
  };
  for (const float angle : {0.1f, 0.29f, 0.35f, 0.45f, 0.55f}) {
    EXPECT_NEAR(irradiance_over_cos(angle), expected(angle), 1e-5f) << angle;
  }
  EXPECT_EQ(irradiance_over_cos(0.61f), 0.0f);
  EXPECT_FALSE(lights.sample({0, 4, 0}, {0, 1, 0}, 0.5f, {0.5f, 0.5f})); // behind it
}

TEST(LightSet, DirectionalLightHasStatedIrradiance) {
  LightSetInput input;
  input.directionals.push_back({{0, 0, -1}, Rgb(1.0f, 2.0f, 3.0f)});
  const LightSet lights(input);
  const auto sample = lights.sample({7, 8, 9}, {0, 1, 0}, 0.0f, {0.5f, 0.5f});
  ASSERT_TRUE(sample);
  EXPECT_TRUE(sample->delta);
  EXPECT_EQ(sample->wi, V3f(0, 0, 1));
  EXPECT_EQ(sample->distance, kInfinity);
  EXPECT_EQ(sample->radiance, Rgb(1.0f, 2.0f, 3.0f));
  EXPECT_FLOAT_EQ(sample->pdf, 1.0f);
}

TEST(LightSet, SelectsTwoLightsByIntensity) {
  LightSetInput input;
  input.points.push_back({{1, 0, 0}, Rgb(3.0f), {}});
  input.points.push_back({{2, 0, 0}, Rgb(0.0f), {}}); // never
  input.spots.push_back({{3, 0, 0}, {0, -1, 0}, Rgb(1.0f), 1.0f, 0.0f, {}});
  const LightSet lights(input);
  EXPECT_EQ(lights.light_count, 2u);
  constexpr int kSamples = 10'000;
  int spot = 0;
  for (int i = 0; i < kSamples; ++i) {
    const auto s = lights.sample({3, -1, 0}, {0, 1, 0}, (static_cast<float>(i) + 0.5f) / kSamples, {0.5f, 0.5f});
    ASSERT_TRUE(s);
    const bool is_spot = s->wi.x == 0.0f;
    spot += is_spot ? 1 : 0;
    ASSERT_FLOAT_EQ(s->pdf, is_spot ? 0.25f : 0.75f);
  }
  EXPECT_EQ(spot, kSamples / 4); // u_light is a grid
}

TEST(LightSet, SelectionFollowsIrradianceAtPoint) {
  LightSetInput input;
  input.points.push_back({{0, 2, 0}, Rgb(4.0f), {}});       // 1 lux below it
  input.directionals.push_back({{0, -1, 0}, Rgb(0.5f)});    // half as strong
  input.directionals.push_back({{-1, 0, 0}, Rgb(1000.0f)}); // grazes a floor, faces a wall
  const LightSet lights(input);
  EXPECT_EQ(lights.light_count, 3u);
  const auto counts = [&](const V3f& normal) {
    std::array<double, 3> seen{};
    constexpr int kSamples = 10'000;
    for (int i = 0; i < kSamples; ++i) {
      const auto s = lights.sample({0, 0, 0}, normal, (static_cast<float>(i) + 0.5f) / kSamples, {0.5f, 0.5f});
      if (!s) continue;
      const size_t which = s->distance < kInfinity ? 0 : s->wi.y == 1.0f ? 1 : 2;
      seen[which] += 1.0 / (kSamples * static_cast<double>(s->pdf)); // each light counts once if its density is correct
    }
    return seen;
  };
  const auto probability_of_first = [&](const V3f& normal) {
    return lights.sample({0, 0, 0}, normal, 0.0f, V2f(0.0f))->pdf;
  };
  // Straight up: the third is below the horizon except for a rounding margin of 0.01 lux, which has
  // the floor of 1/19.
  EXPECT_NEAR(probability_of_first({0, 1, 0}), 1.0f / (1.5f + 1.0f / 19.0f), 0.01f);
  EXPECT_NEAR(probability_of_first(V3f(-0.6f, 0.8f, 0)), 2.0f / 3.0f, 1e-4f);
  // Towards the third: the others are a thousand times weaker and have the floor.
  EXPECT_NEAR(probability_of_first(V3f(0.8f, 0.6f, 0)), 1.0f / 21.0f, 1e-4f);
  for (const V3f& normal : {V3f(0, 1, 0), V3f(0.8f, 0.6f, 0), V3f(0.0f)}) {
    const auto seen = counts(normal);
    for (const double count : seen) EXPECT_NEAR(count, 1.0, 0.02) << normal;
  }
  EXPECT_EQ(counts({0, -1, 0})[0], 0.0);
}

TEST(LightSet, SelectionWeightHasFloor) {
  EXPECT_EQ(light_selection_weight(0.0f, 1.0f), 0.0f);
  EXPECT_EQ(light_selection_weight(1.0f, 1.0f), 1.0f);
  EXPECT_NEAR(light_selection_weight(1.0f, 2.0f), 0.5f, 1e-6f);
  const float floor_weight = light_selection_weight(1e-20f, 1e10f);
  EXPECT_NEAR(floor_weight / (1.0f + floor_weight), 0.05f, 1e-6f);
}

TEST(LightSet, EnvironmentPdfIncludesSelection) {
  LightSetInput input;
  input.emissions = {white(1.0f, true)};
  add_rectangle(input, {0, 5, 0}, {1, 0, 0}, {0, 0, 1}, 0);
  input.environment = std::make_shared<Environment>(test::uneven_image(64, 32), 0.4f, 0.01f);
  const LightSet lights(input);
  EXPECT_EQ(lights.light_count, 3u);
  test::Random random(4);
  int from_environment = 0;
  int different = 0;
  constexpr int kSamples = 50'000;
  for (int i = 0; i < kSamples; ++i) {
    const float u_light = random.next_1d();
    const auto s = lights.sample({0, 0, 0}, {0, 1, 0}, u_light, random.next_2d());
    ASSERT_TRUE(s);
    if (s->distance < kInfinity) continue;
    ++from_environment;
    const EnvironmentEval eval = lights.environment_eval({0, 0, 0}, {0, 1, 0}, s->wi);
    EXPECT_EQ(eval.pdf, lights.pdf_environment({0, 0, 0}, {0, 1, 0}, s->wi));
    EXPECT_EQ(eval.radiance, lights.environment_radiance(s->wi));
    different += std::fabs(eval.pdf - s->pdf) > 1e-3f * s->pdf ? 1 : 0; // at borders of texels
  }
  const V3f up(0, 1, 0);
  const V3f wi = input.environment->sample({0.4f, 0.6f}).wi;
  const double share = lights.pdf_environment({0, 0, 0}, up, wi) / input.environment->pdf(wi);
  EXPECT_GT(share, 0.05);
  EXPECT_LT(share, 0.95);
  EXPECT_NEAR(from_environment, share * kSamples, 5.0 * std::sqrt(share * (1.0 - share) * kSamples));
  EXPECT_LT(different, kSamples / 1000);

  input.triangles.clear();
  const LightSet alone(input);
  EXPECT_TRUE(alone.sample({0, 0, 0}, {0, 1, 0}, 0.0f, {0.5f, 0.5f})->distance == kInfinity);
  EXPECT_TRUE(alone.sample({0, 0, 0}, {0, 1, 0}, kOneMinusEpsilon, {0.5f, 0.5f})->distance == kInfinity);
}

TEST(LightSet, PowerDependsOnTexture) {
  // Left half black, right half 1: the triangle that covers the left half has no power.
  const auto image = float_image(64, 64, [](int x, int) { return x < 32 ? Rgb(0.0f) : Rgb(1.0f, 0.5f, 0.25f); });
  const Texture texture(
      image, {TextureWrap::clamp_to_edge, TextureWrap::clamp_to_edge, TextureFilter::nearest, TextureEncoding::linear});
  LightSetInput input;
  input.emissions = {{Rgb(2.0f), &texture, true}};
  for (const float x : {0.0f, 0.5f}) {
    input.triangles.push_back({{x, 1, 0}, {x + 0.5f, 1, 0}, {x, 1, 1}, 0});
    for (const V2f& uv : {V2f(x, 0), V2f(x + 0.49f, 0), V2f(x, 1)}) input.triangle_uvs.push_back(uv);
  }
  const LightSet lights(input);
  EXPECT_EQ(lights.light_count, 1u);
  EXPECT_EQ(lights.pdf_triangle(0, {0.2f, 0, 0.2f}, {0, 1, 0}, {0, 1, 0}, 1.0f), 0.0f);
  EXPECT_EQ(lights.emitted(1, 0.3f, 0.3f, {0, 1, 0}), Rgb(2.0f, 1.0f, 0.5f));
  EXPECT_EQ(lights.emitted(0, 0.3f, 0.3f, {0, 1, 0}), Rgb(0.0f));
}

TEST(LightSet, HandlesMillionsOfLights) {
  LightSetInput input;
  input.emissions = {white(1.0f, true), white(2.0f, true)};
  constexpr uint32_t kCount = (1U << 20) + 3000;
  input.triangles.reserve(kCount);
  for (uint32_t i = 0; i < kCount; ++i) {
    const auto x = static_cast<float>(i & 1023);
    const auto z = static_cast<float>(i >> 10);
    input.triangles.push_back({{x, 0, z}, {x + 0.5f, 0, z}, {x, 0, z + 0.5f}, i & 1});
  }
  input.points.push_back({{0, 1, 0}, Rgb(5000.0f), {}});
  input.environment = std::make_shared<Environment>(Rgb(1.0f));
  input.scene_radius_m = 800.0f;
  const LightSet lights(input);
  EXPECT_EQ(lights.light_count, kCount + 2u);
  EXPECT_LT(static_cast<double>(lights.memory_bytes()), 110.0 * kCount);

  test::Random random(5);
  const V3f point(512.0f, 40.0f, 512.0f); // far from all of them: sampled by area
  test::Estimate lights_seen;
  constexpr int kSamples = 200'000;
  for (int i = 0; i < kSamples; ++i) {
    const float u_light = random.next_1d();
    const auto s = lights.sample(point, {0, -1, 0}, u_light, random.next_2d());
    if (!s || s->delta || s->distance == kInfinity) {
      lights_seen.add(0.0);
      continue;
    }
    const V3f on_light = point + s->wi * s->distance;
    const auto index = static_cast<uint32_t>(on_light.x + 0.1f) + 1024 * static_cast<uint32_t>(on_light.z + 0.1f);
    ASSERT_NEAR(lights.pdf_triangle(index, point, {0, -1, 0}, s->wi, s->distance), s->pdf, 1e-4f * s->pdf);
    ASSERT_EQ(lights.emitted(index, 0.3f, 0.3f, s->wi), s->radiance);
    // The density is the probability * distance^2 / (area * cosine); its inverse counts the nearer
    // lights.
    const double inverse = square(s->distance) / static_cast<double>(s->pdf * 0.125f * std::fabs(s->wi.y));
    lights_seen.add(on_light.x >= 462 && on_light.x < 562 && on_light.z >= 462 && on_light.z < 562 ? inverse : 0.0);
  }
  EXPECT_NEAR(lights_seen.mean(), 10'000.0, 5.0 * lights_seen.standard_error());
  EXPECT_LT(lights_seen.standard_error(), 150.0); // most samples go to the environment, which is brighter
}

} // namespace
} // namespace kindling
