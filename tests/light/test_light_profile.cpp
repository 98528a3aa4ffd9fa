// Tests of measured luminaires: closed forms, table values, symmetry, flux and LightSet samples.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_profile.h"
#include "renderer/light/light_set.h"
#include "tests/light/light_fixtures.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using Kind = LightProfile::Kind;

std::vector<float> steps(float from, float to, int count) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i)
    values.push_back(from + (to - from) * static_cast<float>(i) / static_cast<float>(count - 1));
  return values;
}

template <typename F>
LightProfile profile_of(Kind kind, const std::vector<float>& vertical, const std::vector<float>& horizontal,
                        const F& f) {
  std::vector<float> candela;
  for (const float h : horizontal)
    for (const float v : vertical) candela.push_back(f(v, h));
  return {kind, vertical, horizontal, candela};
}

float cosine(float degrees) { return std::cos(degrees * kPi / 180.0f); }

// I = 1000 cos: a flat Lambertian luminaire of 1000 pi lumen.
LightProfile lambertian() {
  return profile_of(Kind::c, steps(0, 90, 91), {0.0f}, [](float v, float) { return 1000.0f * cosine(v); });
}

TEST(LightProfile, LambertianMatchesClosedForm) {
  const LightProfile profile = lambertian();
  constexpr float kBetweenSteps = 1000.0f * 3.9e-5f; // second derivative times step^2 / 8
  for (float v = 0.0f; v < 90.0f; v += 0.37f)
    for (float h = 0.0f; h < 360.0f; h += 41.0f)
      EXPECT_NEAR(profile.intensity(LightProfile::direction(Kind::c, v, h)), 1000.0f * cosine(v), kBetweenSteps) << v;
  EXPECT_EQ(profile.intensity({0, 0, 1}), 0.0f);
  EXPECT_NEAR(profile.intensity({0, 0, -1}), 1000.0f, 0.1f);
  EXPECT_EQ(profile.intensity(LightProfile::direction(Kind::c, 91.0f, 10.0f)), 0.0f);
  EXPECT_NEAR(profile.flux(), 1000.0f * kPi, 1.0f);
  EXPECT_NEAR(profile.typical_intensity(), 1000.0f * 2.0f / 3.0f,
              1.0f); // integral of cos^3 over that of cos^2, over sin
}

// Irregular angles: intensity() returns every measured value in the direction given by direction().
TEST(LightProfile, ReproducesTableAtItsAngles) {
  const auto mark = [](float v, float h) { return 1000.0f + 3.0f * v + 0.5f * h; };
  const std::vector<float> all_around = {0, 13, 45, 90, 128.5f, 180, 200, 270, 300, 360};
  const std::vector<float> both_sides = {-90, -45, -44, 0, 7, 60, 90};
  const std::pair<Kind, std::pair<std::vector<float>, std::vector<float>>> cases[] = {
      {Kind::c, {{0, 1, 7.5f, 30, 90, 91, 179}, all_around}},
      {Kind::a, {{-89, -20, 0, 5, 89}, both_sides}},
      {Kind::b, {both_sides, {-89, -20, 0, 5, 89}}},
  };
  for (const auto& [kind, angles] : cases) {
    // Closes the circle with equal values.
    const auto value = [&, k = kind](float v, float h) { return mark(v, k == Kind::c && h == 360.0f ? 0.0f : h); };
    const LightProfile profile = profile_of(kind, angles.first, angles.second, value);
    for (const float v : angles.first) {
      if (kind == Kind::c && v == 0.0f) continue; // all horizontal angles are one direction
      for (const float h : angles.second)
        EXPECT_NEAR(profile.intensity(LightProfile::direction(kind, v, h)), value(v, h), 0.05f)
            << static_cast<int>(kind) << ": " << v << ", " << h;
    }
  }
}

// EXT_lights_ies, "Coordinate System Mapping".
TEST(LightProfile, DirectionsMatchExtension) {
  const auto near = [](const V3f& a, const V3f& b) { return (a - b).length() < 1e-6f; };
  for (const Kind kind : {Kind::a, Kind::b, Kind::c})
    EXPECT_TRUE(near(LightProfile::direction(kind, 0, 0), {0, 0, -1}));
  for (const Kind kind : {Kind::a, Kind::b, Kind::c})
    EXPECT_TRUE(near(LightProfile::direction(kind, 90, 0), {1, 0, 0}));
  EXPECT_TRUE(near(LightProfile::direction(Kind::c, 90, 90), {0, 1, 0}));  // counterclockwise
  EXPECT_TRUE(near(LightProfile::direction(Kind::a, 0, 90), {0, -1, 0}));  // clockwise
  EXPECT_TRUE(near(LightProfile::direction(Kind::b, 45, 90), {0, -1, 0})); // the pole
}

TEST(LightProfile, AppliesSymmetryBeyondTable) {
  const auto value = [](float, float h) { return 100.0f + h; };
  const std::vector<float> vertical = {0, 90, 180};
  const auto at = [&](const LightProfile& profile, float h) {
    return profile.intensity(LightProfile::direction(Kind::c, 90.0f, h));
  };
  const LightProfile quarter = profile_of(Kind::c, vertical, steps(0, 90, 10), value);
  const LightProfile half = profile_of(Kind::c, vertical, steps(0, 180, 19), value);
  const LightProfile turned = profile_of(Kind::c, vertical, steps(90, 270, 19), value);
  for (float h = 1.0f; h < 360.0f; h += 7.0f) {
    const float to_plane = h > 180.0f ? 360.0f - h : h;
    EXPECT_NEAR(at(quarter, h), 100.0f + std::min(to_plane, 180.0f - to_plane), 0.02f) << h;
    EXPECT_NEAR(at(half, h), 100.0f + to_plane, 0.02f) << h;
    EXPECT_NEAR(at(turned, h), 100.0f + (h < 90.0f ? 180.0f - h : h > 270.0f ? 540.0f - h : h), 0.02f) << h;
  }
  const LightProfile flood = profile_of(Kind::b, {0, 45, 90}, {0, 45, 90}, [](float v, float h) { return v + 2 * h; });
  for (const float v : {-40.0f, 40.0f})
    for (const float h : {-30.0f, 30.0f})
      EXPECT_NEAR(flood.intensity(LightProfile::direction(Kind::b, v, h)), 100.0f, 0.02f);
  EXPECT_EQ(flood.intensity({0, 0, 1}), 0.0f); // behind
}

// The irradiance on a sphere around the light integrates to the flux of the table.
TEST(LightProfile, SamplesCarryFluxOfTable) {
  const auto profile = std::make_shared<LightProfile>(profile_of(
      Kind::c, steps(0, 180, 37), steps(0, 180, 13), [](float v, float h) { return 200.0f + v * 2.0f + h; }));
  // The table is linear in both angles. Integrals from 0 to pi: of sin v 2, of v sin v pi; the mean
  // of h is 90.
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const double exact = 2.0 * std::numbers::pi * (2.0 * (200.0 + 90.0) + 2.0 * std::numbers::pi * kDegrees);
  EXPECT_NEAR(static_cast<double>(profile->flux()), exact, exact * 2e-4);

  LightSetInput input;
  const V3f position(1, 2, 3);
  input.profiled.push_back({position, {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}}, Rgb(1.0f, 0.5f, 2.0f), profile});
  const LightSet lights(std::move(input));
  ASSERT_EQ(lights.light_count, 1U);
  constexpr int kRows = 180;
  constexpr int kColumns = 90;
  constexpr float kRadius = 3.0f;
  V3d flux(0.0);
  for (int row = 0; row < kRows; ++row) {
    const float v = (static_cast<float>(row) + 0.5f) * 180.0f / kRows;
    for (int column = 0; column < kColumns; ++column) {
      const V3f outwards = LightProfile::direction(Kind::c, v, (static_cast<float>(column) + 0.5f) * 360.0f / kColumns);
      const auto sample = lights.sample(position + outwards * kRadius, -outwards, 0.5f, {0.5f, 0.5f});
      ASSERT_TRUE(sample);
      EXPECT_TRUE(sample->delta);
      EXPECT_NEAR(sample->distance, kRadius, 1e-4f);
      const double area = 2.0 * std::numbers::pi * std::numbers::pi / (kRows * kColumns) *
                          std::sin(static_cast<double>(v * kPi / 180.0f)) * static_cast<double>(kRadius * kRadius);
      flux += V3d(sample->radiance / sample->pdf) * area;
    }
  }
  EXPECT_NEAR(flux.x, exact, exact * 1e-3);
  EXPECT_NEAR(flux.y, 0.5 * exact, exact * 5e-4);
  EXPECT_NEAR(flux.z, 2.0 * exact, exact * 2e-3);
}

TEST(LightProfile, FrameRotatesDistribution) {
  // The light is bright only along +x of its frame, which is world -z.
  const auto profile =
      std::make_shared<LightProfile>(profile_of(Kind::c, {0, 90, 180}, {0, 90, 180, 270, 360}, [](float v, float h) {
        return v == 90.0f && (h == 0.0f || h == 360.0f) ? 8.0f : 0.0f;
      }));
  LightSetInput input;
  input.profiled.push_back({{0, 0, 0}, {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}}, Rgb(1.0f), profile});
  const LightSet lights(std::move(input));
  const auto lit = lights.sample({0, 0, -2}, {0, 0, 1}, 0.5f, {0.5f, 0.5f});
  ASSERT_TRUE(lit);
  EXPECT_NEAR(lit->radiance.x, 8.0f / 4.0f, 1e-4f);
  EXPECT_FALSE(lights.sample({0, 0, 2}, {0, 0, -1}, 0.5f, {0.5f, 0.5f}));
}

// Beside another light, samples and their probabilities sum to both lights, and both are sampled.
TEST(LightProfile, SelectionAmongOthersIsUnbiased) {
  LightSetInput input;
  input.points.push_back({{2, 1, 0}, Rgb(50.0f), {}});
  for (const float x : {-1.0f, 0.5f, 1.5f})
    input.profiled.push_back(
        {{x, 2, 0}, {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, Rgb(0.1f), std::make_shared<LightProfile>(lambertian())});
  const LightSet lights(input);
  EXPECT_EQ(lights.light_count, 4U);
  double expected = 50.0 / 5.0;
  for (const double x : {-1.0, 0.5, 1.5}) expected += 100.0 * (2.0 / std::sqrt(x * x + 4.0)) / (x * x + 4.0);
  double sum = 0.0;
  constexpr int kCount = 4096;
  for (int i = 0; i < kCount; ++i) {
    const auto sample = lights.sample({0, 0, 0}, {0, 1, 0}, (static_cast<float>(i) + 0.5f) / kCount, {0.25f, 0.5f});
    if (sample) sum += static_cast<double>(sample->radiance.x / sample->pdf);
  }
  // A stratum on the border between two choices may be counted to either.
  EXPECT_NEAR(sum / kCount, expected, expected * 5e-3);
}

TEST(LightProfile, DarkProfilesAreNeverSelected) {
  LightSetInput input;
  input.profiled.push_back(
      {{0, 1, 0},
       {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
       Rgb(1.0f),
       std::make_shared<LightProfile>(Kind::c, std::vector{0.0f}, std::vector{0.0f}, std::vector{0.0f})});
  EXPECT_TRUE(LightSet(std::move(input)).empty());
}

} // namespace
} // namespace kindling
