// Statistical tests of lights against quadrature or closed forms, and of densities against samples.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"
#include "tests/light/light_fixtures.h"
#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::add_rectangle;
using test::Estimate;
using test::float_image;
using test::sampled_irradiance;

// Sampled means must lie within five standard errors: a false alarm once in 1.7 million.
void expect_agreement(const Estimate& estimate, double expected, const char* what) {
  EXPECT_NEAR(estimate.mean(), expected, 5.0 * estimate.standard_error() + 1e-5 * expected) << what;
  // Ensures that the test is significant.
  EXPECT_LT(estimate.standard_error(), 0.01 * expected) << what;
}

// Returns the form factor from a small element to a parallel a x b rectangle at distance h with a
// corner straight above the element.
double corner_form_factor(double a, double b, double h) {
  const double x = a / h;
  const double y = b / h;
  const double sx = std::sqrt(1.0 + x * x);
  const double sy = std::sqrt(1.0 + y * y);
  return (x / sx * std::atan(y / sx) + y / sy * std::atan(x / sy)) / (2.0 * std::numbers::pi);
}

TEST(LightStatistics, RectangleMatchesFormFactor) {
  // Near (by solid angle), far (by area), and in between.
  for (const float height : {0.05f, 0.5f, 2.0f, 15.0f, 60.0f}) {
    LightSetInput input;
    input.emissions = {{Rgb(2.0f), nullptr, false}};
    add_rectangle(input, {-1.0f, height, -0.5f}, {2, 0, 0}, {0, 0, 1}, 0); // x cross z is -y: emits downwards
    const LightSet lights(input);
    const double h = static_cast<double>(height);
    const double expected = 2.0 * std::numbers::pi * 4.0 * corner_form_factor(1.0, 0.5, h);
    expect_agreement(sampled_irradiance(lights, {0, 0, 0}, {0, 1, 0}, 200'000, 1), expected, "center");
    const double corner = 2.0 * std::numbers::pi * corner_form_factor(2.0, 1.0, h);
    expect_agreement(sampled_irradiance(lights, {-1.0f, 0, -0.5f}, {0, 1, 0}, 400'000, 2), corner, "corner");
  }
}

TEST(LightStatistics, TexturedEmissionMatchesQuadrature) {
  const auto image = float_image(16, 16, [](int x, int y) {
    test::Random random(static_cast<uint64_t>(y * 16 + x));
    return x > 3 && x < 9 ? Rgb(0.0f) : Rgb{random.next_1d() * 5.0f, random.next_1d(), y == 5 ? 30.0f : 0.0f};
  });
  const Texture texture(
      image, {TextureWrap::clamp_to_edge, TextureWrap::clamp_to_edge, TextureFilter::linear, TextureEncoding::linear});
  LightSetInput input;
  input.emissions = {{Rgb(2.0f, 1.0f, 0.5f), &texture, true}};
  const V3f corner(-1, 1.5f, -1);
  add_rectangle(input, corner, {2, 0, 0}, {0, 0, 2}, 0);
  input.triangle_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
  const LightSet lights(input);
  const V3f point(0.3f, 0, -0.2f);

  constexpr int kSteps = 512; // midpoints; bilinear cells are 32 steps wide
  double expected = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const V2f uv((static_cast<float>(i) + 0.5f) / kSteps, (static_cast<float>(j) + 0.5f) / kSteps);
      const V3f to_light = corner + V3f(2.0f * uv.x, 0, 2.0f * uv.y) - point;
      const double d2 = static_cast<double>(to_light.length2());
      const double cos2 = square(to_light.y) / d2; // at both ends
      const Rgb radiance = input.emissions[0].factor * texture.sample_rgb(uv);
      expected += static_cast<double>(luminance(radiance)) * cos2 / d2 * 4.0 / (kSteps * kSteps);
    }
  }
  expect_agreement(sampled_irradiance(lights, point, {0, 1, 0}, 1'000'000, 3), expected, "textured");
}

TEST(LightStatistics, EnvironmentIrradianceMatchesQuadrature) {
  for (const float rotation : {0.0f, 1.1f}) {
    const auto environment = std::make_shared<Environment>(test::uneven_image(40, 20), rotation, 0.5f);
    LightSetInput input;
    input.environment = environment;
    const LightSet lights(input);
    for (const V3f& normal : {V3f(0, 1, 0), V3f(0, -1, 0), V3f(0.6f, 0, -0.8f), V3f(-0.48f, 0.6f, 0.64f)}) {
      constexpr int kSteps = 20 * 32;
      double expected = 0.0;
      for (int y = 0; y < kSteps; ++y) {
        const double theta = std::numbers::pi * (y + 0.5) / kSteps;
        for (int x = 0; x < 2 * kSteps; ++x) {
          const double phi = std::numbers::pi * (x + 0.5) / kSteps;
          const V3f d(static_cast<float>(std::sin(theta) * std::cos(phi)), static_cast<float>(std::cos(theta)),
                      static_cast<float>(std::sin(theta) * std::sin(phi)));
          const double cosine = std::max(static_cast<double>(d.dot(normal)), 0.0);
          expected += static_cast<double>(luminance(environment->radiance(d))) * cosine * std::sin(theta);
        }
      }
      expected *= std::pow(std::numbers::pi / kSteps, 2.0);
      const Estimate estimate = sampled_irradiance(lights, {0, 0, 0}, normal, 1'000'000, 4);
      // The quadrature itself is accurate to 1e-3: the interpolation has kinks every 32 steps.
      EXPECT_NEAR(estimate.mean(), expected, 5.0 * estimate.standard_error() + 1e-3 * expected) << normal;
    }
  }
}

TEST(LightStatistics, EnvironmentTotalRadianceMatchesQuadrature) {
  for (const int height : {1, 2, 3, 20}) {
    const Environment environment(test::float_image(2 * height + 1, height,
                                                    [](int x, int y) {
                                                      test::Random random(static_cast<uint64_t>(x * 100 + y));
                                                      return Rgb(random.next_1d(), 1.0f, 0.0f);
                                                    }),
                                  0.7f, 2.0f);
    constexpr int kSteps = 1200;
    V3d sum(0.0);
    for (int y = 0; y < kSteps; ++y) {
      const double theta = std::numbers::pi * (y + 0.5) / kSteps;
      for (int x = 0; x < kSteps; ++x) {
        const double phi = 2.0 * std::numbers::pi * (x + 0.5) / kSteps;
        const Rgb c = environment.radiance({static_cast<float>(std::sin(theta) * std::cos(phi)),
                                            static_cast<float>(std::cos(theta)),
                                            static_cast<float>(std::sin(theta) * std::sin(phi))});
        sum += V3d(static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z)) * std::sin(theta);
      }
    }
    sum *= 2.0 * std::numbers::pi * std::numbers::pi / (static_cast<double>(kSteps) * kSteps);
    EXPECT_NEAR(static_cast<double>(environment.total_radiance.x), sum.x, 1e-3 * sum.x) << height;
    EXPECT_NEAR(static_cast<double>(environment.total_radiance.y), 8.0 * std::numbers::pi, 2e-4) << height;
    EXPECT_EQ(environment.total_radiance.z, 0.0f);
  }
}

// Directions are binned to quarters of texels, where the density can be integrated without
// quadrature.
TEST(LightStatistics, EnvironmentSamplingMatchesPdf) {
  constexpr int kWidth = 37;
  constexpr int kHeight = 19;
  constexpr float kRotation = 0.9f;
  constexpr int kSamples = 2'000'000;
  const Environment environment(test::uneven_image(kWidth, kHeight), kRotation, 1.0f);

  std::vector<double> expected(4 * kWidth * kHeight);
  std::vector<double> observed(expected.size(), 0.0);
  double integral = 0.0;
  for (int y = 0; y < 2 * kHeight; ++y) {
    const double top = std::cos(std::numbers::pi * y / (2 * kHeight));
    const double bottom = std::cos(std::numbers::pi * (y + 1) / (2 * kHeight));
    const double theta = std::numbers::pi * (y + 0.5) / (2 * kHeight);
    for (int x = 0; x < 2 * kWidth; ++x) {
      const double phi = 2.0 * std::numbers::pi * ((x + 0.5) / (2 * kWidth) - 0.5) - static_cast<double>(kRotation);
      const V3f center(static_cast<float>(std::sin(theta) * std::cos(phi)), static_cast<float>(std::cos(theta)),
                       static_cast<float>(std::sin(theta) * std::sin(phi)));
      const double mass = static_cast<double>(environment.pdf(center)) * (top - bottom) * std::numbers::pi / kWidth;
      expected[static_cast<size_t>(y * 2 * kWidth + x)] = mass * kSamples;
      integral += mass;
    }
  }
  EXPECT_NEAR(integral, 1.0, 5e-4); // densities are rounded to 2^-11

  test::Random random(5);
  for (int i = 0; i < kSamples; ++i) {
    const V3f d = environment.sample(random.next_2d()).wi;
    double u = 0.5 + (std::atan2(static_cast<double>(d.z), static_cast<double>(d.x)) + static_cast<double>(kRotation)) /
                         (2.0 * std::numbers::pi);
    u -= std::floor(u);
    const double v = std::acos(std::clamp(static_cast<double>(d.y), -1.0, 1.0)) / std::numbers::pi;
    const int x = std::min(static_cast<int>(u * 2 * kWidth), 2 * kWidth - 1);
    const int y = std::min(static_cast<int>(v * 2 * kHeight), 2 * kHeight - 1);
    observed[static_cast<size_t>(y * 2 * kWidth + x)] += 1.0;
  }
  double statistic = 0.0;
  double pooled_expected = 0.0;
  double pooled_observed = 0.0;
  int cells = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    if (expected[i] < 8.0) {
      pooled_expected += expected[i];
      pooled_observed += observed[i];
      continue;
    }
    statistic += square(static_cast<float>(observed[i] - expected[i])) / expected[i];
    ++cells;
  }
  if (pooled_expected > 8.0) {
    statistic += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
    ++cells;
  } else {
    EXPECT_LT(pooled_observed, pooled_expected + 5.0 * std::sqrt(pooled_expected) + 5.0);
  }
  EXPECT_GT(test::chi_square_tail(statistic, cells - 1), 1e-4) << statistic << " in " << cells << " cells";
}

TEST(LightStatistics, TriangleSamplingMatchesPdf) {
  const EmissiveTriangle triangle{{-1, 2, -0.5f}, {1, 2.2f, -0.4f}, {0.2f, 2, 1}, 0};
  const V3f points[] = {{0, 0, 0},   {0.1f, 1.95f, 0.1f},    {-3, 1.8f, 0.5f},
                        {4, -20, 7}, {-1.01f, 2.0f, -0.51f}, {0, 3, 0}};
  LightSetInput input;
  input.emissions = {{Rgb(1.0f), nullptr, true}};
  input.triangles = {triangle};
  const LightSet lights(input);
  const V3f e1 = triangle.p1 - triangle.p0;
  const V3f e2 = triangle.p2 - triangle.p0;
  const V3f normal = e1.cross(e2);
  const double level = test::sidak_level(0.01, static_cast<int>(std::size(points)));
  for (const V3f& point : points) {
    // Uses the square that maps to the triangle with constant density: b1 = 1 - sqrt(x), b2 = y
    // sqrt(x).
    const auto draw = [&](test::Random& random) -> std::optional<std::array<double, 2>> {
      const float u_light = random.next_1d();
      const auto s = lights.sample(point, {0, 1, 0}, u_light, random.next_2d());
      if (!s) return std::nullopt;
      const V3d hit = V3d(point) + V3d(s->wi) * static_cast<double>(s->distance) - V3d(triangle.p0);
      const V3d n(normal);
      const double b1 = hit.cross(V3d(e2)).dot(n) / n.length2();
      const double b2 = V3d(e1).cross(hit).dot(n) / n.length2();
      const double root = std::clamp(1.0 - b1, 1e-9, 1.0);
      return std::array<double, 2>{root * root, std::clamp(b2 / root, 0.0, 1.0)};
    };
    const auto density = [&](double x, double y) {
      const auto root = static_cast<float>(std::sqrt(x));
      const V3f to_light = triangle.p0 + e1 * (1.0f - root) + e2 * (static_cast<float>(y) * root) - point;
      const float distance = to_light.length();
      const V3f wi = to_light * (1.0f / distance);
      const float per_area =
          lights.pdf_triangle(0, point, {0, 1, 0}, wi, distance) * 0.5f * std::fabs(normal.dot(wi)) / square(distance);
      return static_cast<double>(per_area);
    };
    const test::ChiSquareResult result = test::chi_square_test({0, 1, 0, 1}, draw, density, {.seed = 6});
    EXPECT_GT(result.p_value, level) << point << ": " << result.summary;
    EXPECT_NEAR(result.integral, 1.0, 2e-3) << point;
  }
}

TEST(LightStatistics, SpotLightFluxMatchesClosedForm) {
  // Integrating E over a plane below the lamp gives the flux through it: 2 pi times the integral of
  // I sin(theta).
  LightSetInput input;
  SpotLight spot;
  spot.position = {0.5f, 3, 0.25f};
  spot.axis = {0, -1, 0};
  spot.intensity = Rgb(10.0f);
  spot.cos_inner = std::cos(0.2f);
  spot.cos_outer = std::cos(0.7f);
  input.spots = {spot};
  const LightSet lights(input);
  // Falloff ((c - co) / (ci - co))^2 between the cones: the integral over c is (ci - co) / 3.
  const double ci = static_cast<double>(spot.cos_inner);
  const double co = static_cast<double>(spot.cos_outer);
  const double expected = 10.0 * 2.0 * std::numbers::pi * ((1.0 - ci) + (ci - co) / 3.0);
  constexpr int kSteps = 2000;
  constexpr double kExtent = 3.0; // half: 3 m * tan(0.7) is 2.53
  double flux = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const V3f point(0.5f + static_cast<float>((2.0 * (i + 0.5) / kSteps - 1.0) * kExtent), 0.0f,
                      0.25f + static_cast<float>((2.0 * (j + 0.5) / kSteps - 1.0) * kExtent));
      const auto s = lights.sample(point, {0, 1, 0}, 0.5f, {0.5f, 0.5f});
      if (s) flux += static_cast<double>(s->radiance.x * s->wi.y / s->pdf);
    }
  }
  flux *= std::pow(2.0 * kExtent / kSteps, 2.0);
  EXPECT_NEAR(flux, expected, 1e-3 * expected);
}

TEST(LightStatistics, AllLightKindsAddUp) {
  LightSetInput input;
  input.emissions = {{Rgb(2.0f), nullptr, false}, {Rgb(0.3f), nullptr, true}};
  add_rectangle(input, {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}, 0);
  add_rectangle(input, {3, 0.5f, -1}, {0, 2, 0}, {0, 0, 2}, 1);
  input.points.push_back({{0, 3, 1}, Rgb(4.0f), {}});
  input.directionals.push_back({V3f(0.6f, -0.8f, 0.0f), Rgb(0.5f)});
  input.environment = std::make_shared<Environment>(Rgb(0.25f));
  input.scene_radius_m = 3.0f;
  const LightSet lights(input);

  // Without occlusion, each light contributes as if it were alone.
  const double ceiling = 2.0 * std::numbers::pi * 4.0 * corner_form_factor(1.0, 1.0, 2.0);
  const double point = 4.0 / 10.0 * 3.0 / std::sqrt(10.0);
  const double sun = 0.5 * 0.8;
  const double sky = std::numbers::pi * 0.25;
  double wall = 0.0;
  constexpr int kSteps = 800;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const V3d d(3.0, 0.5 + 2.0 * (i + 0.5) / kSteps, -1.0 + 2.0 * (j + 0.5) / kSteps);
      wall += 0.3 * (d.y * d.x) / (d.length2() * d.length2()) * 4.0 / (kSteps * kSteps);
    }
  }
  const Estimate estimate = sampled_irradiance(lights, {0, 0, 0}, {0, 1, 0}, 1'000'000, 7);
  expect_agreement(estimate, ceiling + point + sun + sky + wall, "all");
}

} // namespace
} // namespace kindling
