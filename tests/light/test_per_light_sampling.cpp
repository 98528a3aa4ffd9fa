// Tests of PerLightSampling: every light by itself, with preserved stratification.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/per_light_sampling.h"
#include "tests/light/light_fixtures.h"

#include <gtest/gtest.h>

#include <set>

namespace kindling {
namespace {

using test::add_rectangle;
using test::Estimate;

// Estimates the irradiance from one light.
Estimate irradiance_by(const PerLightSampling& lights, size_t light, const V3f& point, const V3f& normal,
                       size_t samples) {
  test::Random random(3);
  Estimate estimate;
  for (size_t i = 0; i < samples; ++i) {
    const auto s = lights.sample(light, point, normal, random.next_2d());
    estimate.add(s ? static_cast<double>(luminance(s->radiance) * s->wi.dot(normal) / s->pdf) : 0.0);
  }
  return estimate;
}

LightSetInput one_of_each() {
  LightSetInput input;
  input.emissions = {{Rgb(2.0f), nullptr, false}, {Rgb(0.0f), nullptr, false}, {Rgb(1.0f), nullptr, true}};
  add_rectangle(input, {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}, 0); // emits downwards
  input.triangles.push_back({{5, 0, 0}, {5, 1, 0}, {5, 0, 1}, 1});
  input.triangles.push_back({{0, 1, 3}, {0.3f, 1, 3}, {0, 1.5f, 3}, 2});
  input.triangles.push_back({{0, 1, 3}, {0.3f, 1, 3}, {0.5f, 0.5f, 3.2f}, 2});
  input.triangles.push_back({{0.5f, 2, 3}, {0.7f, 2, 3}, {0.5f, 2, 3.2f}, 2});
  input.meshes = {{0, 2, "ceiling"}, {2, 1, "dark"}, {3, 3, "rags"}};
  input.points.push_back({{0, 3, 0}, Rgb(18.0f), {}, "bulb"});
  input.points.push_back({{0, 3, 0}, Rgb(0.0f), {}, "off"});
  input.directionals.push_back({{0, -1, 0}, Rgb(3.0f), "sun"});
  input.environment = std::make_shared<Environment>(Rgb(0.5f));
  return input;
}

TEST(PerLightSampling, ListsEmittingLights) {
  const LightSet set(one_of_each());
  const PerLightSampling lights(set);
  std::vector<std::string> names;
  for (size_t i = 0; i < lights.count(); ++i) names.emplace_back(lights.name(i));
  EXPECT_EQ(names, (std::vector<std::string>{"ceiling", "rags", "bulb", "sun", "environment"}));
  EXPECT_FALSE(lights.is_delta(0));
  EXPECT_TRUE(lights.is_delta(2));
  EXPECT_TRUE(lights.is_delta(3));
  EXPECT_FALSE(lights.is_delta(4));
  EXPECT_EQ(PerLightSampling(LightSet{LightSetInput{}}).count(), 0U);
}

// Each light contributes as if alone, and together they contribute as the set does.
TEST(PerLightSampling, SumMatchesLightSet) {
  const LightSetInput input = one_of_each();
  const LightSet set(input);
  const PerLightSampling lights(set);
  const V3f point(0.4f, 0, 0.3f), normal(0, 1, 0);
  double sum = 0.0, variance = 0.0;
  for (size_t i = 0; i < lights.count(); ++i) {
    const Estimate estimate = irradiance_by(lights, i, point, normal, 200'000);
    sum += estimate.mean();
    variance += square(estimate.standard_error());
  }
  const Estimate all = test::sampled_irradiance(set, point, normal, 400'000, 5);
  EXPECT_NEAR(sum, all.mean(), 5.0 * std::sqrt(variance + square(all.standard_error())));
  EXPECT_LT(all.standard_error(), 0.005 * sum);
  EXPECT_NEAR(irradiance_by(lights, 4, point, normal, 400'000).mean(), 0.5 * std::numbers::pi, 0.01);
  EXPECT_FALSE(lights.sample(2, point, {0, -1, 0}, {0.5f, 0.5f})); // below the horizon
  EXPECT_TRUE(lights.sample(2, point, V3f(0.0f), {0.5f, 0.5f}));
}

TEST(PerLightSampling, ParallelogramStrataAreItsCells) {
  const V3f corner(-1, 2, -1), a(2, 0.5f, 0), b(0.3f, 0, 1.5f);
  // For any split into two triangles and any first corner.
  for (int turn = 0; turn < 9; ++turn) {
    LightSetInput input;
    input.emissions = {{Rgb(1.0f), nullptr, true}};
    add_rectangle(input, corner, a, b, 0);
    const auto rotate = [](EmissiveTriangle& t, int by) {
      for (; by > 0; --by) t = {t.p1, t.p2, t.p0, t.emission};
    };
    rotate(input.triangles[0], turn % 3);
    rotate(input.triangles[1], turn / 3);
    input.meshes = {{0, 2, "panel"}};
    const LightSet set(input);
    const PerLightSampling lights(set);
    const V3f point(0.2f, 0.3f, 0.1f);
    constexpr int kStrata = 16;
    std::set<std::pair<int, int>> cells;
    for (int i = 0; i < kStrata * kStrata; ++i) {
      const V2f u((static_cast<float>(i % kStrata) + 0.5f) / kStrata,
                  (static_cast<float>(i / kStrata) + 0.5f) / kStrata);
      const auto s = lights.sample(0, point, V3f(0.0f), u);
      ASSERT_TRUE(s);
      const V3f on = point + s->wi * s->distance - corner;
      const V3f n = a.cross(b);
      const float x = on.cross(b).dot(n) / n.length2(), y = a.cross(on).dot(n) / n.length2();
      // Centers of strata map to centers of cells.
      ASSERT_NEAR(x * kStrata - std::floor(x * kStrata), 0.5f, 1e-3f);
      ASSERT_NEAR(y * kStrata - std::floor(y * kStrata), 0.5f, 1e-3f);
      cells.insert({static_cast<int>(x * kStrata), static_cast<int>(y * kStrata)});
      const float area_pdf = s->pdf * std::fabs(n.normalized().dot(s->wi)) / square(s->distance);
      ASSERT_NEAR(area_pdf * n.length(), 1.0f, 1e-4f);
    }
    EXPECT_EQ(cells.size(), static_cast<size_t>(kStrata * kStrata)) << turn;
  }
}

TEST(PerLightSampling, DoesNotMergeNonParallelograms) {
  LightSetInput input;
  input.emissions = {{Rgb(1.0f), nullptr, true}, {Rgb(4.0f), nullptr, true}};
  const V3f point(0.1f, 0, 0.2f), normal(0, 1, 0);
  const auto expect_as_set = [&](const char* what) {
    input.meshes = {{0, 2, "panel"}};
    const LightSet set(input);
    const Estimate whole = irradiance_by(PerLightSampling(set), 0, point, normal, 200'000);
    const Estimate all = test::sampled_irradiance(set, point, normal, 200'000, 5);
    EXPECT_NEAR(whole.mean(), all.mean(), 5.0 * std::hypot(whole.standard_error(), all.standard_error())) << what;
  };
  add_rectangle(input, {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}, 0);
  input.triangles[1].emission = 1;
  expect_as_set("two emissions");
  input.triangles[1].emission = 0;
  input.triangles[1].p2 += V3f(0, 0, 1);
  expect_as_set("a kite");
  input.triangles[1].p2 += V3f(0, 1, 0);
  expect_as_set("folded");
}

} // namespace
} // namespace kindling
