// Statistical tests of the light tree: choices, estimates, and variance against power sampling.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_tree.h"
#include "tests/light/light_soup.h"
#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Estimate;
using test::light_soup;
using test::Random;
using test::random_direction;
using test::random_point;
using test::sampled_irradiance;

TEST(LightTreeStatistics, ChoicesMatchProbabilities) {
  Random random(21);
  constexpr int kPoints = 20;
  constexpr int kSamples = 200'000;
  constexpr uint32_t kCount = 400;
  std::vector<EmitterBounds> emitters(kCount);
  for (EmitterBounds& e : emitters) {
    e.center = random_point(random, 5.0f);
    e.axis = random_direction(random);
    e.radius = 0.2f * random.next_1d();
    e.intensity = 0.1f + random.next_1d();
    e.back = random.next_1d() < 0.3f ? 1.0f : 0.0f;
  }
  const LightTree tree(emitters);
  int all_cells = 0;
  for (int i = 0; i < kPoints; ++i) {
    const V3f point = random_point(random, 7.0f);
    const V3f normal = i % 4 == 0 ? V3f(0.0f) : random_direction(random);
    std::vector<double> observed(kCount + 1, 0.0); // the last counts empty choices
    for (int k = 0; k < kSamples; ++k) {
      const auto choice = tree.choose(point, normal, static_cast<double>(random.next_1d()));
      observed[choice ? choice->emitter : kCount] += 1.0;
    }
    std::vector<double> expected(kCount + 1, 0.0);
    expected[kCount] = kSamples;
    for (uint32_t e = 0; e < kCount; ++e) {
      expected[e] = static_cast<double>(tree.probability(e, point, normal)) * kSamples;
      expected[kCount] -= expected[e];
      if (expected[e] == 0.0) {
        ASSERT_EQ(observed[e], 0.0);
      }
    }
    double statistic = 0.0;
    double few_expected = 0.0;
    double few_observed = 0.0;
    int cells = 0;
    for (size_t e = 0; e <= kCount; ++e) {
      if (expected[e] < 10.0) {
        few_expected += std::max(expected[e], 0.0);
        few_observed += observed[e];
        continue;
      }
      statistic += std::pow(observed[e] - expected[e], 2.0) / expected[e];
      ++cells;
    }
    if (few_expected > 10.0) {
      statistic += std::pow(few_observed - few_expected, 2.0) / few_expected;
      ++cells;
    } else {
      EXPECT_LT(few_observed, few_expected + 5.0 * std::sqrt(few_expected) + 5.0);
    }
    all_cells += cells;
    if (cells < 2) continue; // outside, facing away: no choices
    EXPECT_GT(test::chi_square_tail(statistic, cells - 1), test::sidak_level(0.001, kPoints)) << point << normal;
  }
  EXPECT_GT(all_cells, 50 * kPoints);
}

// Samples the same input one light at a time, without selection and bounds.
Estimate light_by_light(const LightSetInput& input, const V3f& point, const V3f& normal, size_t samples) {
  double mean = 0.0;
  double variance = 0.0;
  uint32_t seed = 100;
  const auto add = [&](LightSetInput one) {
    const LightSet alone(std::move(one));
    if (alone.empty()) return;
    const Estimate estimate = sampled_irradiance(alone, point, normal, samples, ++seed);
    mean += estimate.mean();
    variance += estimate.standard_error() * estimate.standard_error();
  };
  for (size_t i = 0; i < input.triangles.size(); ++i) {
    LightSetInput one;
    one.emissions = input.emissions;
    one.triangles = {input.triangles[i]};
    one.triangle_uvs.assign(input.triangle_uvs.begin() + static_cast<std::ptrdiff_t>(3 * i),
                            input.triangle_uvs.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
    add(std::move(one));
  }
  for (const PointLight& light : input.points) add({.points = {light}});
  for (const SpotLight& light : input.spots) add({.spots = {light}});
  for (const DirectionalLight& light : input.directionals) add({.directionals = {light}});
  if (input.environment) add({.environment = input.environment});
  Estimate total;
  total.count = 2; // two values that far apart have this mean and this standard error
  total.sum = 2.0 * mean;
  total.sum_of_squares = 2.0 * (mean * mean + 2.0 * variance);
  return total;
}

TEST(LightTreeStatistics, EstimatesMatchPerLightSums) {
  const auto image = test::float_image(8, 8, [](int x, int y) { return Rgb(static_cast<float>((x ^ y) & 3)); });
  const Texture texture(image,
                        {TextureWrap::repeat, TextureWrap::repeat, TextureFilter::linear, TextureEncoding::linear});
  Random random(22);
  for (uint32_t soup = 0; soup < 6; ++soup) {
    LightSetInput input = light_soup(soup, soup == 0 ? 7 : 150, soup % 2 == 1 ? 12 : 0, soup >= 3 ? 12 : 1, &texture);
    if (soup >= 4) {
      input.directionals.push_back({random_direction(random), Rgb(0.4f)});
      input.environment = std::make_shared<Environment>(Rgb(0.05f));
    }
    const LightSet lights(input);
    for (int i = 0; i < 4; ++i) {
      const V3f point = random_point(random, 9.0f);
      const V3f normal = random_direction(random);
      const Estimate expected = light_by_light(input, point, normal, 4000);
      const Estimate estimate = sampled_irradiance(lights, point, normal, 400'000, 23 + soup);
      const double error = std::hypot(expected.standard_error(), estimate.standard_error());
      EXPECT_NEAR(estimate.mean(), expected.mean(), 5.0 * error) << "soup " << soup << " point " << i;
      // Ensures that the test is significant; the seven triangles of the first soup hardly light
      // the place.
      if (soup > 0) {
        EXPECT_LT(error, 0.02 * expected.mean()) << "soup " << soup << " point " << i;
      }
    }
  }
}

// pdf_triangle() at a hit must equal the density that sample() reports.
TEST(LightTreeStatistics, HitPdfMatchesSamplePdf) {
  LightSetInput input = light_soup(31, 120, 3, 3, nullptr);
  input.directionals.push_back({{0, -1, 0}, Rgb(0.4f)});
  input.environment = std::make_shared<Environment>(Rgb(0.05f));
  const LightSet lights(input);
  Random random(32);
  int compared = 0;
  for (int i = 0; i < 20'000; ++i) {
    const V3f point = random_point(random, 9.0f);
    const V3f normal = random_direction(random);
    const float u_light = random.next_1d();
    const auto s = lights.sample(point, normal, u_light, random.next_2d());
    if (!s || s->delta || s->distance == kInfinity) continue;
    const V3f on_light = point + s->wi * s->distance;
    // Finds the triangle that contains the sample.
    float nearest = kInfinity;
    uint32_t found = 0;
    for (uint32_t t = 0; t < input.triangles.size(); ++t) {
      const EmissiveTriangle& triangle = input.triangles[t];
      const V3f whole = (triangle.p1 - triangle.p0).cross(triangle.p2 - triangle.p0);
      if (!(whole.length() > 0.0f) || std::fabs(std::fabs(whole.normalized().dot(s->normal)) - 1.0f) > 1e-4f) continue;
      const V3f a = triangle.p0 - on_light, b = triangle.p1 - on_light, c = triangle.p2 - on_light;
      const float excess = (a.cross(b).length() + b.cross(c).length() + c.cross(a).length()) / whole.length() - 1.0f;
      if (excess < nearest) {
        nearest = excess;
        found = t;
      }
    }
    if (nearest > 1e-2f) continue; // too small for this test's arithmetic
    ++compared;
    const float pdf = lights.pdf_triangle(found, point, normal, s->wi, s->distance);
    ASSERT_NEAR(pdf, s->pdf, 1e-3f * s->pdf) << found;
  }
  EXPECT_GT(compared, 5000);
}

// A hall with many small lamps: the variance of one sample against selection by power.
TEST(LightTreeStatistics, HasLessVarianceThanPowerSampling) {
  Random random(41);
  LightSetInput input;
  input.emissions = {{Rgb(5.0f), nullptr, false}, {Rgb(20.0f), nullptr, false}};
  for (int i = 0; i < 500; ++i) {
    const V3f corner{40.0f * random.next_1d() - 20.0f, 2.0f + 4.0f * random.next_1d(),
                     40.0f * random.next_1d() - 20.0f};
    test::add_rectangle(input, corner, {0.2f, 0, 0}, {0, 0, 0.2f}, i % 2 == 0 ? 0 : 1);
  }
  const LightSet lights(input);
  // By power: lamps of the two emissions have similar areas, so a fifth of the choices goes to the
  // first.
  std::vector<LightSet> alone;
  for (const EmissiveTriangle& t : input.triangles) {
    alone.emplace_back(LightSetInput{.emissions = input.emissions, .triangles = {t}});
  }
  double log_ratio = 0.0;
  constexpr int kPoints = 20;
  for (int i = 0; i < kPoints; ++i) {
    const V3f point{30.0f * random.next_1d() - 15.0f, 0.0f, 30.0f * random.next_1d() - 15.0f};
    const V3f normal = (V3f(0, 1, 0) + random_direction(random) * 0.9f).normalized();
    const Estimate tree = sampled_irradiance(lights, point, normal, 20'000, 42);
    Estimate power;
    for (int k = 0; k < 100'000; ++k) {
      const bool bright = random.next_1d() < 0.8f;
      const auto lamp = static_cast<size_t>(random.next_1d() * 250.0f) * 2 + (bright ? 1 : 0);
      const auto half = static_cast<size_t>(random.next_1d() * 2.0f);
      const float u_light = random.next_1d();
      const auto s = alone[2 * lamp + half].sample(point, normal, u_light, random.next_2d());
      const float cosine = s ? std::max(s->wi.dot(normal), 0.0f) : 0.0f;
      const float probability = (bright ? 0.8f : 0.2f) / 500.0f;
      power.add(s ? static_cast<double>(luminance(s->radiance) * cosine / (s->pdf * probability)) : 0.0);
    }
    const double error = std::hypot(tree.standard_error(), power.standard_error());
    EXPECT_NEAR(tree.mean(), power.mean(), 5.0 * error);
    const double tree_variance = std::pow(tree.standard_error(), 2.0) * 20'000;
    const double power_variance = std::pow(power.standard_error(), 2.0) * 100'000;
    log_ratio += std::log(power_variance / tree_variance) / kPoints;
  }
  EXPECT_GT(std::exp(log_ratio), 10.0); // 20 when this was written
}

} // namespace
} // namespace kindling
