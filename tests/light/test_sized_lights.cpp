// Tests of punctual lights with a size: directions, irradiance, and intersection with rays.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_set.h"
#include "renderer/light/sphere_seen.h"
#include "renderer/sampling/mis.h"
#include "tests/light/light_fixtures.h"
#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Estimate;
using test::sampled_irradiance;

constexpr double kPiD = std::numbers::pi;

// Sampled means must lie within five standard errors: a false alarm once in 1.7 million.
void expect_close_agreement(const Estimate& estimate, double expected, const char* what) {
  EXPECT_NEAR(estimate.mean(), expected, 5.0 * estimate.standard_error() + 2e-6 * expected) << what;
  EXPECT_LE(estimate.standard_error(), 0.01 * expected) << what;
}

TEST(SizedLights, SphereDirectionsAreUniform) {
  struct Case {
    float distance, radius;
  };
  constexpr Case kCases[] = {{10.0f, 0.05f}, {2.0f, 1.0f}, {1.001f, 1.0f}, {0.999f, 1.0f}, {0.0f, 1.0f}};
  uint64_t seed = 1;
  for (const Case& c : kCases) {
    const SphereSeen sphere(V3f(0.36f, -0.48f, 0.8f) * c.distance, c.radius);
    const test::ChiSquareResult result = test::chi_square_sphere(
        [&](test::Random& r) -> std::optional<V3f> { return sphere.sample(r.next_2d()); },
        [&](const V3f& w) { return sphere.distance(w) ? sphere.pdf() : 0.0f; }, {.seed = seed++});
    EXPECT_GT(result.p_value, test::sidak_level(1e-4, std::size(kCases))) << c.distance << ": " << result.summary;
    EXPECT_NEAR(result.integral, 1.0, 0.01) << c.distance;
  }
}

TEST(SizedLights, SphereDistancesMatchIntersection) {
  test::Random random(2);
  for (const float distance : {50.0f, 3.0f, 1.1f, 0.7f, 0.0f}) {
    const V3f center = V3f(0.6f, 0.0f, -0.8f) * distance;
    const SphereSeen sphere(center, 1.0f);
    for (int i = 0; i < 1000; ++i) {
      const V3f wi = sphere.sample(random.next_2d());
      const float t = sphere.sampled_distance(wi);
      // On the surface, on its near side; at the silhouette the square root of a rounding error
      // remains.
      EXPECT_NEAR((wi * t - center).length(), 1.0f, 2e-6f * std::max(distance, 1.0f));
      const float facing = (wi * t - center).dot(wi);
      EXPECT_TRUE(distance < 1.0f ? facing >= 0.0f : facing <= 3e-3f * distance) << facing;
      const auto met = sphere.distance(wi);
      EXPECT_EQ(met.value_or(t), t);
    }
  }
  const SphereSeen sphere(V3f(0, 0, 3), 1.0f);
  EXPECT_FALSE(sphere.distance(V3f(0, 0, -1))); // behind
  EXPECT_FALSE(sphere.distance(V3f(1, 0, 0)));
  EXPECT_FLOAT_EQ(*sphere.distance(V3f(0, 0, 1)), 2.0f);
  EXPECT_FLOAT_EQ(*SphereSeen(V3f(0, 0, 0.5f), 1.0f).distance(V3f(0, 0, 1)), 1.5f); // from inside, where the ray leaves
}

// A uniform sphere above the horizon: pi L (r / d)^2 cos, which is the point's intensity cos / d^2.
TEST(SizedLights, SphereIrradianceEqualsPoint) {
  const V3f normal = V3f(0.3f, 1.0f, 0.2f).normalized();
  const V3f to_light(0.5f, 2.0f, -0.4f);
  const double expected = 7.0 * static_cast<double>(normal.dot(to_light.normalized()) / to_light.length2());
  for (const float radius : {0.0f, 1e-5f, 0.01f, 0.3f, 1.2f}) {
    LightSetInput input;
    input.points.push_back({.position = to_light, .intensity = Rgb(7.0f), .radius_m = radius});
    const LightSet lights(input);
    EXPECT_EQ(lights.has_shapes, radius > 0.0f);
    expect_close_agreement(sampled_irradiance(lights, V3f(0.0f), normal, 100'000, 1), expected, "point");
    if (radius == 0.0f) continue;
    // Nineteen other lights give the tree a choice.
    for (int i = 0; i < 19; ++i) {
      const V3f at(static_cast<float>(i) - 9.0f, 3.0f, 1.0f);
      input.points.push_back({.position = at, .intensity = Rgb(1.0f), .radius_m = 0.1f});
    }
    double all = expected;
    for (size_t i = 1; i < input.points.size(); ++i)
      all +=
          static_cast<double>(normal.dot(input.points[i].position.normalized()) / input.points[i].position.length2());
    expect_close_agreement(sampled_irradiance(LightSet(input), V3f(0.0f), normal, 400'000, 2), all, "many");
  }
}

// Returns the irradiance of a plane with normal +y from a cone of directions, in double precision:
// midpoints in 1 - cos and in angle.
template <typename Radiance>
double irradiance_of_cone(const V3d& axis, double one_minus_cos_max, const Radiance& radiance) {
  constexpr int kSteps = 600;
  const V3d x = (std::fabs(axis.x) < 0.5 ? axis.cross(V3d(1, 0, 0)) : axis.cross(V3d(0, 0, 1))).normalized();
  const V3d y = axis.cross(x);
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double one_minus_cos = one_minus_cos_max * (i + 0.5) / kSteps;
    const double sine = std::sqrt(one_minus_cos * (2.0 - one_minus_cos));
    for (int j = 0; j < kSteps; ++j) {
      const double phi = 2.0 * kPiD * (j + 0.5) / kSteps;
      const V3d wi = axis * (1.0 - one_minus_cos) + x * (sine * std::cos(phi)) + y * (sine * std::sin(phi));
      if (wi.y > 0.0) sum += wi.y * radiance(wi);
    }
  }
  return sum * 2.0 * kPiD * one_minus_cos_max / (kSteps * kSteps);
}
// For a sphere around `center`, seen from the origin; from inside it covers all directions.
double one_minus_cos_of(const V3d& center, double radius) {
  const double sin2 = radius * radius / center.length2();
  return sin2 < 1.0 ? 1.0 - std::sqrt(1.0 - sin2) : 2.0;
}

TEST(SizedLights, SpheresCutByHorizonMatchQuadrature) {
  for (const float height : {0.6f, 0.0f, -0.5f, 0.9f}) {
    const V3f center(height == 0.9f ? 0.0f : 1.2f, height, 0.0f); // the last: the point is inside
    LightSetInput input;
    input.points.push_back({.position = center, .intensity = Rgb(2.0f), .radius_m = 1.0f});
    const V3d c(center);
    const V3d axis = V3d(center).normalized();
    const double expected = irradiance_of_cone(axis, one_minus_cos_of(c, 1.0), [](const V3d&) { return 2.0 / kPiD; });
    const Estimate estimate = sampled_irradiance(LightSet(input), V3f(0.0f), {0, 1, 0}, 400'000, 3);
    // The quadrature resolves the horizon to a step: 1/600 of the diameter, equally on either side.
    EXPECT_NEAR(estimate.mean(), expected, 5.0 * estimate.standard_error() + 1e-3 * expected) << height;
    // Beside other lamps, which adds a choice.
    input.points.push_back({.position = V3f(0, 5, 0), .intensity = Rgb(3.0f)});
    input.points.push_back({.position = V3f(0, -5, 0), .intensity = Rgb(3.0f)});
    const Estimate with = sampled_irradiance(LightSet(input), V3f(0.0f), {0, 1, 0}, 400'000, 4);
    EXPECT_NEAR(with.mean(), expected + 3.0 / 25.0, 5.0 * with.standard_error() + 1e-3 * expected) << height;
  }
}

TEST(SizedLights, SpotsKeepCone) {
  LightSetInput input;
  SpotLight spot{.position = {0, 4, 0}, .axis = {0, -1, 0}, .intensity = Rgb(8.0f)};
  spot.cos_inner = std::cos(0.3f);
  spot.cos_outer = std::cos(0.5f);
  spot.range_m = 9.0f;
  spot.radius_m = 0.5f;
  input.spots.push_back(spot);
  const LightSet lights(input);
  for (const float x : {0.0f, 0.9f, 1.6f, 2.2f, 2.6f}) {
    // Each point of the sphere emits the spot's intensity over pi r^2 in every direction.
    const V3d c(-static_cast<double>(x), 4.0, 0.0);
    const double window = 1.0 - std::pow(c.length() / 9.0, 4.0);
    const double expected = irradiance_of_cone(c.normalized(), one_minus_cos_of(c, 0.5), [&](const V3d& wi) {
      const double cone = (wi.y - std::cos(0.5)) / (std::cos(0.3) - std::cos(0.5));
      return 8.0 / (kPiD * 0.25) * window * std::pow(std::clamp(cone, 0.0, 1.0), 2.0);
    });
    const Estimate estimate = sampled_irradiance(lights, V3f(x, 0, 0), {0, 1, 0}, 200'000, 3);
    EXPECT_NEAR(estimate.mean(), expected, 5.0 * estimate.standard_error() + 1e-4 * expected + 1e-9) << x;
  }
  EXPECT_FALSE(lights.sample(V3f(0, 6, 0), V3f(0.0f), 0.5f, {0.5f, 0.5f})); // behind it
}

TEST(SizedLights, SkyDisksKeepIrradiance) {
  for (const float degrees : {0.0f, 0.53f, 5.0f, 60.0f}) {
    LightSetInput input;
    const V3f to_sun = V3f(1.0f, 2.0f, 0.5f).normalized();
    input.directionals.push_back(
        {.direction = -to_sun, .irradiance = Rgb(3.0f), .angular_diameter_rad = degrees * kPi / 180.0f});
    const LightSet lights(input);
    expect_close_agreement(sampled_irradiance(lights, V3f(0.0f), to_sun, 50'000, 5), 3.0, "facing");
    // The projection of a disk that is entirely above the horizon is that of its center.
    if (degrees < 50.0f) {
      const V3f normal(0, 1, 0);
      expect_close_agreement(sampled_irradiance(lights, V3f(0.0f), normal, 50'000, 6),
                             3.0 * static_cast<double>(normal.dot(to_sun)), "from the side");
    }
  }
}

TEST(SizedLights, SettingSunMatchesQuadrature) {
  constexpr float kDiameter = 0.4f;
  for (const float elevation : {0.15f, 0.0f, -0.1f}) {
    const V3f to_sun(std::cos(elevation), std::sin(elevation), 0.0f);
    LightSetInput input;
    input.directionals.push_back({.direction = -to_sun, .irradiance = Rgb(3.0f), .angular_diameter_rad = kDiameter});
    input.directionals.push_back({.direction = {0, -1, 0}, .irradiance = Rgb(0.5f)});
    const double sine = std::sin(0.5 * static_cast<double>(kDiameter));
    const double expected = 0.5 + irradiance_of_cone(V3d(to_sun).normalized(), 1.0 - std::sqrt(1.0 - sine * sine),
                                                     [&](const V3d&) { return 3.0 / (kPiD * sine * sine); });
    const Estimate estimate = sampled_irradiance(LightSet(input), V3f(0.0f), {0, 1, 0}, 400'000, 7);
    EXPECT_NEAR(estimate.mean(), expected, 5.0 * estimate.standard_error() + 1e-3 * expected) << elevation;
  }
}

// A room full of lights of all kinds with and without a size.
LightSetInput many_kinds(size_t count) {
  LightSetInput input;
  test::Random random(11);
  const auto anywhere = [&] { return V3f{random.next_1d(), random.next_1d(), random.next_1d()} * 8.0f - V3f(4.0f); };
  for (size_t i = 0; i < count; ++i) {
    PointLight point{.position = anywhere(), .intensity = Rgb(random.next_1d() + 0.1f)};
    if (i % 3 != 0) point.radius_m = 0.05f + 0.3f * random.next_1d();
    input.points.push_back(point);
    if (i % 4 == 0)
      input.spots.push_back({.position = anywhere(),
                             .axis = (anywhere() + V3f(0.01f)).normalized(),
                             .intensity = Rgb(2.0f),
                             .cos_inner = 0.9f,
                             .cos_outer = 0.5f,
                             .radius_m = 0.2f});
  }
  input.directionals.push_back(
      {.direction = V3f(0.6f, -0.8f, 0), .irradiance = Rgb(0.3f), .angular_diameter_rad = 0.3f});
  input.directionals.push_back({.direction = V3f(0, -0.6f, 0.8f), .irradiance = Rgb(0.2f)});
  return input;
}

// A ray collects what each light contributes by itself; without competing light sampling there are
// no weights.
TEST(SizedLights, RaysHitEverySphereAndDisk) {
  for (const size_t count : {2U, 300U}) {
    const LightSetInput input = many_kinds(count);
    const LightSet lights(input);
    test::Random random(5);
    size_t met = 0;
    for (int i = 0; i < 3000; ++i) {
      const V3f origin = V3f{random.next_1d(), random.next_1d(), random.next_1d()} * 10.0f - V3f(5.0f);
      V3f wi = sample_uniform_sphere(random.next_2d()); // some of them towards a light or along an axis
      if (i % 2 == 0)
        wi = (input.points[static_cast<size_t>(i / 2) % count].position + wi * 0.2f - origin).normalized();
      if (i % 50 == 1) wi = V3f(0.0f, 0.0f, 1.0f);
      const float end = i % 4 < 2 ? kInfinity : 6.0f * random.next_1d();
      double expected = 0.0;
      const auto add = [&](const V3f& position, float radius, float intensity, double falloff) {
        if (radius == 0.0f) return;
        const auto t = SphereSeen(position - origin, radius).distance(wi);
        if (t && *t < end)
          expected += static_cast<double>(intensity) * falloff / (kPiD * static_cast<double>(radius * radius));
      };
      for (const PointLight& p : input.points) add(p.position, p.radius_m, p.intensity.x, 1.0);
      for (const SpotLight& s : input.spots) {
        const auto cosine = static_cast<double>(-s.axis.dot(wi));
        add(s.position, s.radius_m, s.intensity.x, std::pow(std::clamp((cosine - 0.5) / 0.4, 0.0, 1.0), 2.0));
      }
      if (end == kInfinity && wi.dot(V3f(-0.6f, 0.8f, 0)) > std::cos(0.15f))
        expected += 0.3 / (kPiD * std::pow(std::sin(0.15), 2.0));
      const Rgb found =
          lights.shape_radiance({.origin = origin, .normal = V3f(0, 1, 0), .direction = wi, .end_m = end});
      ASSERT_NEAR(found.x, expected, 1e-4 * expected + 1e-6) << i;
      met += expected > 0.0 ? 1 : 0;
    }
    EXPECT_GT(met, 100U);
  }
}

// The interval of the ray and the extinction within it.
TEST(SizedLights, RespectsRayInterval) {
  LightSetInput input;
  input.points.push_back({.position = {0, 0, 5}, .intensity = Rgb(kPi), .radius_m = 1.0f});
  const LightSet lights(input);
  const auto seen = [&](float begin, float end, float extinction = 0.0f) {
    return lights
        .shape_radiance({.origin = V3f(0.0f),
                         .normal = V3f(0.0f),
                         .direction = {0, 0, 1},
                         .begin_m = begin,
                         .end_m = end,
                         .extinction = Rgb(extinction)})
        .x;
  };
  EXPECT_FLOAT_EQ(seen(0.0f, kInfinity), 1.0f);
  EXPECT_EQ(seen(0.0f, 3.99f), 0.0f);
  EXPECT_FLOAT_EQ(seen(3.99f, 4.01f), 1.0f); // its front
  EXPECT_EQ(seen(4.01f, kInfinity), 0.0f);   // only the first surface counts
  EXPECT_FLOAT_EQ(seen(1.0f, kInfinity, 0.5f), std::exp(-1.5f));
}

// The MIS weights of rays must use the density that samples have.
TEST(SizedLights, MisWeightsUseSamplePdf) {
  for (const size_t count : {1U, 40U}) {
    const LightSet lights(many_kinds(count));
    test::Random random(9);
    int compared = 0;
    for (int i = 0; i < 20'000; ++i) {
      const V3f point = V3f{random.next_1d(), random.next_1d(), random.next_1d()} * 6.0f - V3f(3.0f);
      const V3f normal = i % 3 == 0 ? V3f(0.0f) : sample_uniform_sphere(random.next_2d());
      const float u_light = random.next_1d();
      const auto s = lights.sample(point, normal, u_light, random.next_2d());
      if (!s || s->delta) continue;
      const auto along = [&](float bsdf_pdf) {
        const bool disk = s->distance == kInfinity;
        return lights.shape_radiance({.origin = point,
                                      .normal = normal,
                                      .direction = s->wi,
                                      .begin_m = disk ? 1e6f : s->distance * (1.0f - 1e-5f),
                                      .end_m = disk ? kInfinity : s->distance * (1.0f + 1e-5f) + 1e-6f,
                                      .bsdf_pdf = bsdf_pdf});
      };
      if (std::fabs(along(0.0f).x - s->radiance.x) > 1e-4f * s->radiance.x) continue; // at an edge
      ++compared;
      const float bsdf_pdf = s->pdf * 1.7f;
      ASSERT_NEAR(along(bsdf_pdf).x, s->radiance.x * power_heuristic(bsdf_pdf, s->pdf), 1e-3f * s->radiance.x);
    }
    EXPECT_GT(compared, 2000);
  }
}

} // namespace
} // namespace kindling
