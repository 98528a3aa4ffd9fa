// Tests of emitted rays: their distribution, their densities and their radiance.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/emission_sampling.h"
#include "renderer/light/light_set.h"
#include "renderer/sampling/warp.h"
#include "tests/light/light_fixtures.h"
#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

#include <array>

namespace kindling {
namespace {

using test::Estimate;
using test::Random;

const Box3f kScene(V3f(-4.0f), V3f(4.0f));

// One overlaps another, one is far away.
std::vector<EmissionTarget> three_targets() {
  return {{V3f(0, 0, 0), 0.8f}, {V3f(0.5f, 0.2f, 0.3f), 0.6f}, {V3f(-3, 1, -2), 0.3f}};
}

EmissionDraws draws_of(Random& random) {
  const float light = random.next_1d(), target = random.next_1d();
  const V2f position = random.next_2d();
  return {light, target, position, random.next_2d()};
}

LightSetInput input_of_triangle(bool two_sided) {
  LightSetInput input;
  input.emissions.push_back({.factor = Rgb(3.0f, 2.0f, 1.0f), .two_sided = two_sided});
  input.triangles.push_back({V3f(-1, 2, -1), V3f(1, 2.4f, -1), V3f(0, 2, 1), 0});
  return input;
}

LightSetInput input_of_point(float radius) {
  LightSetInput input;
  input.points.push_back(
      {.position = V3f(1, 2, 0.5f), .intensity = Rgb(5.0f), .range_m = std::nullopt, .name = {}, .radius_m = radius});
  return input;
}

LightSetInput input_of_sun(float angle) {
  LightSetInput input;
  input.directionals.push_back(
      {.direction = V3f(0.6f, -0.8f, 0), .irradiance = Rgb(2.0f), .name = {}, .angular_diameter_rad = angle});
  return input;
}

TEST(Emission, DirectionsOfASphereHaveTheirDensity) {
  const LightSet lights(input_of_point(0.2f));
  const EmissionSampling emission(lights, three_targets(), kScene);
  const V3f center(1, 2, 0.5f);
  const test::ChiSquareResult result = test::chi_square_sphere(
      [&](Random& random) -> std::optional<V3f> {
        const auto ray = emission.sample(draws_of(random));
        return ray ? std::optional(ray->direction) : std::nullopt;
      },
      [&](const V3f& w) { return emission.direction_density(center, w); }, {.seed = 1});
  EXPECT_GT(result.p_value, 1e-4) << result.summary;
  EXPECT_NEAR(result.integral, 1.0, 0.01);
}

TEST(Emission, FromInsideOfATargetAllDirectionsArePossible) {
  const LightSet lights(input_of_point(0.0f));
  const EmissionSampling emission(lights, {{V3f(1, 2, 0), 1.0f}, {V3f(0.0f), 0.5f}}, kScene);
  const test::ChiSquareResult result = test::chi_square_sphere(
      [&](Random& random) -> std::optional<V3f> { return emission.sample(draws_of(random))->direction; },
      [&](const V3f& w) { return emission.direction_density(V3f(1, 2, 0.5f), w); }, {.seed = 2});
  EXPECT_GT(result.p_value, 1e-4) << result.summary;
  EXPECT_NEAR(result.integral, 1.0, 0.01);
}

// Positions in the plane through the origin that the sun's rays cross at right angles.
TEST(Emission, ParallelRaysHaveTheirDensity) {
  const LightSet lights(input_of_sun(0.0f));
  const EmissionSampling emission(lights, three_targets(), kScene);
  const V3f direction(0.6f, -0.8f, 0), x(0.8f, 0.6f, 0), y(0, 0, 1);
  const test::ChiSquareResult result = test::chi_square_test(
      {-5.0, 5.0, -5.0, 5.0},
      [&](Random& random) -> std::optional<std::array<double, 2>> {
        const auto ray = emission.sample(draws_of(random));
        EXPECT_LT((ray->direction - direction).length(), 1e-6f);
        return std::array<double, 2>{static_cast<double>(ray->origin.dot(x)), static_cast<double>(ray->origin.dot(y))};
      },
      [&](double u, double v) {
        return emission.disk_density(x * static_cast<float>(u) + y * static_cast<float>(v), direction);
      },
      {.seed = 3});
  EXPECT_GT(result.p_value, 1e-4) << result.summary;
  EXPECT_NEAR(result.integral, 1.0, 0.01);
}

// The mean of 1 / density is the étendue of all rays that can be sampled; another estimate of it
// draws points and directions uniformly.
TEST(Emission, TrianglesHaveTheEtendueOfTheirRays) {
  for (const bool two_sided : {false, true}) {
    const LightSetInput input = input_of_triangle(two_sided);
    const LightSet lights(input);
    const EmissionSampling emission(lights, three_targets(), kScene);
    const EmissiveTriangle& t = input.triangles[0];
    const V3f normal = (t.p1 - t.p0).cross(t.p2 - t.p0).normalized();
    const float area = 0.5f * (t.p1 - t.p0).cross(t.p2 - t.p0).length();
    Random random(4);
    Estimate sampled, uniform;
    for (int i = 0; i < 400000; ++i) {
      const auto ray = emission.sample(draws_of(random));
      sampled.add(ray ? 1.0 / static_cast<double>(ray->density) : 0.0);
      if (ray) {
        const float cosine = normal.dot(ray->direction);
        EXPECT_NEAR(ray->density / emission.triangle_density(0, ray->origin, ray->direction, cosine), 1.0f, 1e-4f);
        EXPECT_TRUE(two_sided || cosine > 0.0f);
      }
      const V2f b = sample_uniform_triangle(random.next_2d());
      const V3f from = t.p0 * (1.0f - b.x - b.y) + t.p1 * b.x + t.p2 * b.y;
      const V3f direction = sample_uniform_sphere(random.next_2d());
      const float cosine = normal.dot(direction);
      const bool possible =
          (two_sided || cosine > 0.0f) && emission.triangle_density(0, from, direction, cosine) > 0.0f;
      uniform.add(possible ? static_cast<double>(area * 4.0f * kPi * std::abs(cosine)) : 0.0);
    }
    EXPECT_NEAR(sampled.mean(), uniform.mean(), 5.0 * std::hypot(sampled.standard_error(), uniform.standard_error()));
    EXPECT_LT(uniform.standard_error(), 0.01 * uniform.mean());
  }
}

// Light on a target far away, by emitted rays and by light samples from there at that time.
void expect_light_of_samples(const LightSetInput& input, float time) {
  const V3f at(0, -40, 0);
  const float radius = 0.5f;
  const LightSet lights(input);
  const EmissionSampling emission(lights, {{at, 2.0f * radius}}, kScene); // rays of spheres miss a part of it
  Random random(5);
  Estimate power, irradiance;
  for (int i = 0; i < 200000; ++i) {
    EmissionDraws draws = draws_of(random);
    draws.time = time;
    if (const auto ray = emission.sample(draws)) {
      EXPECT_EQ(ray->time, time);
      const float before = (at - ray->origin).dot(ray->direction);
      const V3f nearest = ray->origin + ray->direction * before;
      const bool hits = (nearest - at).length() < radius; // a disk that faces the ray
      power.add(hits ? static_cast<double>(luminance(emission.radiance(*ray, nearest)) / ray->finite_density) : 0.0);
    } else {
      power.add(0.0);
    }
    const V2f u = random.next_2d();
    const auto sample =
        lights.sample({.point = at, .normal = V3f(0.0f), .u = u, .digits = random.next_1d(), .time = time});
    irradiance.add(sample ? static_cast<double>(luminance(sample->radiance) / sample->pdf) : 0.0);
  }
  const double area = static_cast<double>(kPi * radius * radius);
  // The disk is not small: distances vary by radius / 40.
  EXPECT_NEAR(power.mean() / area, irradiance.mean(),
              5.0 * std::hypot(power.standard_error() / area, irradiance.standard_error()) + 2e-3 * irradiance.mean())
      << "at time " << time;
}

TEST(Emission, RaysCarryTheLightThatSamplesFind) {
  for (const LightSetInput& input :
       {input_of_triangle(true), input_of_point(0.2f), input_of_point(0.0f), input_of_sun(0.0f), input_of_sun(0.05f)})
    expect_light_of_samples(input, 0.0f);
}

LightFrame frame_towards(const V3f& position, const V3f& direction) {
  LightFrame frame;
  frame.position = position;
  frame.z = -direction.normalized();
  return frame;
}

// A triangle that grows and turns, a sphere that comes nearer, a cone that turns, a disk that does.
std::vector<LightSetInput> moving_inputs() {
  std::vector<LightSetInput> inputs{input_of_triangle(true), input_of_point(0.2f), {}, input_of_sun(0.05f)};
  inputs[0].moving = {{0, 1}};
  inputs[0].later_corners = {{V3f(-2, 1, -1), V3f(1.5f, -1, -2), V3f(0, 1, 3)}};
  inputs[1].points[0].later = {frame_towards(V3f(0, -20, 0), V3f(0, -1, 0))};
  inputs[2].spots.push_back({.position = V3f(0, 1, 0),
                             .axis = V3f(0, -1, 0),
                             .intensity = Rgb(5.0f),
                             .cos_inner = 0.95f,
                             .cos_outer = 0.6f,
                             .later = {frame_towards(V3f(4, 1, 0), V3f(0.5f, -1, 0))}});
  inputs[3].directionals[0].later = {frame_towards(V3f(0.0f), V3f(-0.3f, -1, 0.2f))};
  return inputs;
}

TEST(Emission, MovingLightsEmitFromWhereTheyAre) {
  for (const LightSetInput& input : moving_inputs())
    for (const float time : {0.0f, 0.3f, 1.0f}) expect_light_of_samples(input, time);
}

TEST(Emission, DensitiesOfMovingLightsAreThoseOfTheirRays) {
  for (const LightSetInput& input : moving_inputs()) {
    const LightSet lights(input);
    const EmissionSampling emission(lights, three_targets(), kScene);
    Random random(6);
    for (int i = 0; i < 1000; ++i) {
      EmissionDraws draws = draws_of(random);
      draws.time = random.next_1d();
      const auto ray = emission.sample(draws);
      if (!ray) continue;
      float density = 0.0f;
      if (lights.triangles.empty()) {
        density = emission.punctual_density(0, ray->origin, ray->direction, ray->time);
      } else {
        const V3f normal = double_area_normal(lights.posed_triangle(0, ray->time)).normalized();
        density = emission.triangle_density(0, ray->origin, ray->direction, normal.dot(ray->direction), ray->time);
      }
      if (ray->density == kInfinity)
        EXPECT_EQ(density, kInfinity);
      else
        EXPECT_NEAR(density / ray->density, 1.0f, 2e-4f);
    }
  }
}

TEST(Emission, IsEmptyWithoutLightsOrTargets) {
  const LightSet dark{LightSetInput{}};
  EXPECT_TRUE(EmissionSampling(dark, three_targets(), kScene).empty());
  const LightSet lights(input_of_point(0.1f));
  EXPECT_TRUE(EmissionSampling(lights, {}, kScene).empty());
  EXPECT_FALSE(EmissionSampling(lights, three_targets(), kScene).empty());
}

TEST(Emission, LightsWithoutASizeHaveInfiniteDensity) {
  const LightSet lights(input_of_point(0.0f));
  const EmissionSampling emission(lights, three_targets(), kScene);
  const V3f from(1, 2, 0.5f);
  EXPECT_EQ(emission.punctual_density(0, from, (-from).normalized()), kInfinity);
  EXPECT_EQ(emission.punctual_density(0, from, V3f(0, 1, 0)), 0.0f);
}

} // namespace
} // namespace kindling
