// Tests of lights that move over the shutter against static lights posed at the same time.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/per_light_sampling.h"
#include "renderer/sampling/warp.h"
#include "tests/light/light_fixtures.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Estimate;

constexpr float kTimes[] = {0.0f, 0.2f, 0.5f, 0.77f, 1.0f};

Estimate irradiance_at(const LightSet& lights, const V3f& point, const V3f& normal,
                       const std::function<float(size_t)>& time, size_t samples, uint32_t seed) {
  test::Random random(seed);
  Estimate estimate;
  for (size_t i = 0; i < samples; ++i) {
    const LightQuery query{
        .point = point, .normal = normal, .u = random.next_2d(), .digits = random.next_1d(), .time = time(i)};
    const auto s = lights.sample(query);
    const float cosine = s ? std::max(s->wi.dot(normal), 0.0f) : 0.0f;
    estimate.add(cosine > 0.0f ? static_cast<double>(luminance(s->radiance) * cosine / s->pdf) : 0.0);
  }
  return estimate;
}

// Triangles with two to six keys anywhere in a cube, half of them on individual paths, some
// flipping over; one-sided and two-sided.
LightSetInput flock(size_t still, size_t moving) {
  LightSetInput input;
  input.emissions = {{Rgb(2.0f), nullptr, false}, {Rgb(1.0f), nullptr, true}};
  test::Random random(3);
  const auto anywhere = [&](float size) {
    return (V3f{random.next_1d(), random.next_1d(), random.next_1d()} - V3f(0.5f)) * size;
  };
  for (size_t i = 0; i < still + moving; ++i) {
    const V3f at = anywhere(6.0f);
    EmissiveTriangle t{at, at + anywhere(1.0f), at + anywhere(1.0f), static_cast<uint32_t>(i % 2)};
    input.triangles.push_back(t);
    if (i < still) continue;
    CornerKeys keys{static_cast<uint32_t>(input.later_corners.size()), 1 + static_cast<uint32_t>(i % 5)};
    const V3f course = anywhere(3.0f);
    for (uint32_t key = 1; key <= keys.count; ++key) {
      const V3f shift = course * (static_cast<float>(key) / static_cast<float>(keys.count));
      const float turn = i % 3 == 0 ? 1.0f : i % 3 == 1 ? 0.1f : 0.0f;
      input.later_corners.push_back(
          {t.p0 + shift + anywhere(turn), t.p1 + shift + anywhere(turn), t.p2 + shift + anywhere(turn)});
    }
    input.moving.push_back(keys);
  }
  return input;
}

// Returns the same lights, static, posed at a time.
LightSetInput frozen(const LightSetInput& input, float time) {
  LightSetInput result = input;
  const size_t still = input.triangles.size() - input.moving.size();
  for (size_t i = 0; i < input.moving.size(); ++i) {
    const CornerKeys& keys = input.moving[i];
    EmissiveTriangle& t = result.triangles[still + i];
    const auto corner = [&](uint32_t key, size_t c) {
      const EmissiveTriangle& first = input.triangles[still + i];
      return key == 0 ? (c == 0   ? first.p0
                         : c == 1 ? first.p1
                                  : first.p2)
                      : input.later_corners[keys.first + key - 1][c];
    };
    const float at = time * static_cast<float>(keys.count);
    const uint32_t key = std::min(static_cast<uint32_t>(at), keys.count - 1);
    const float f = at - static_cast<float>(key);
    V3f* corners[3] = {&t.p0, &t.p1, &t.p2};
    for (size_t c = 0; c < 3; ++c) *corners[c] = corner(key, c) * (1.0f - f) + corner(key + 1, c) * f;
  }
  result.moving.clear();
  result.later_corners.clear();
  return result;
}

TEST(MovingLights, TrianglesMatchStaticOnesAtSameTime) {
  const V3f point(0.3f, -0.5f, 0.2f), normal = V3f(0.2f, 1.0f, -0.3f).normalized();
  for (const size_t count : {1U, 60U}) {
    const LightSetInput input = flock(count / 2, count);
    const LightSet moving(input);
    for (const float time : kTimes) {
      const LightSet still(frozen(input, time));
      const Estimate a = irradiance_at(
          moving, point, normal, [&](size_t) { return time; }, 40'000, 1);
      const Estimate b = irradiance_at(
          still, point, normal, [](size_t) { return 0.0f; }, 40'000, 2);
      EXPECT_NEAR(a.mean(), b.mean(), 5.0 * std::hypot(a.standard_error(), b.standard_error()) + 1e-9)
          << count << " " << time;
      EXPECT_LE(a.standard_error(), 0.05 * a.mean() + 1e-9);
    }
  }
}

// Compares samples with the density at a hit of the same place, and verifies that every light can
// be sampled.
TEST(MovingLights, PdfMatchesSamplesAtSameTime) {
  const LightSetInput input = flock(20, 60);
  const LightSet lights(input);
  test::Random random(5);
  int shining = 0;
  for (int i = 0; i < 4000; ++i) {
    const float time = i % 10 == 0 ? 1.0f : random.next_1d();
    const V3f point = (V3f{random.next_1d(), random.next_1d(), random.next_1d()} - V3f(0.5f)) * 8.0f;
    const V3f normal = i % 4 == 0 ? V3f(0.0f) : sample_uniform_sphere(random.next_2d());
    const LightSetInput here = frozen(input, time);
    const auto s = lights.sample(
        {.point = point, .normal = normal, .u = random.next_2d(), .digits = random.next_1d(), .time = time});
    float density = 0.0f;
    for (uint32_t t = 0; t < here.triangles.size(); ++t) {
      const EmissiveTriangle& triangle = here.triangles[t];
      const V3f middle = (triangle.p0 + triangle.p1 + triangle.p2) / 3.0f;
      const V3f wi = (middle - point).normalized();
      const V3f cross = (triangle.p1 - triangle.p0).cross(triangle.p2 - triangle.p0);
      const bool lit = normal == V3f(0.0f) || wi.dot(normal) > 1e-3f;
      const bool lights_up = t % 2 == 1 || cross.dot(wi) < -1e-3f * cross.length();
      if (lit && lights_up && cross.length() > 1e-3f) {
        EXPECT_GT(lights.pdf_triangle(t, point, normal, wi, (middle - point).length(), nullptr, time), 0.0f) << t;
        ++shining;
      }
      if (!s) continue;
      // The sampled triangle is the one whose plane contains the sample.
      const V3f on_light = point + s->wi * s->distance;
      const V3f b0 = (on_light - triangle.p0).cross(triangle.p1 - triangle.p0);
      const V3f b1 = (on_light - triangle.p1).cross(triangle.p2 - triangle.p1);
      const V3f b2 = (on_light - triangle.p2).cross(triangle.p0 - triangle.p2);
      const bool inside = std::fabs(b0.length() + b1.length() + b2.length() - cross.length()) < 1e-4f * cross.length();
      if (!inside) continue;
      density = std::max(density, lights.pdf_triangle(t, point, normal, s->wi, s->distance, nullptr, time));
    }
    if (!s) continue;
    EXPECT_NEAR(density, s->pdf, 2e-3f * s->pdf) << i;
  }
  EXPECT_GT(shining, 50'000);
}

LightFrame frame_towards(const V3f& position, const V3f& direction) {
  LightFrame frame;
  frame.position = position;
  frame.z = -direction.normalized();
  return frame;
}

TEST(MovingLights, PunctualLightsMatchStaticOnesAtSameTime) {
  const V3f a(-1, 2, 0), b(2, 1.5f, 1), c(1, 3, -1);
  const V3f down(0.1f, -1, 0), aside(0.8f, -1, 0.3f);
  const V3f point(0.2f, 0, 0.1f), normal(0, 1, 0);
  for (const float radius : {0.0f, 0.3f}) {
    LightSetInput input;
    input.points.push_back({.position = a,
                            .intensity = Rgb(2.0f),
                            .radius_m = radius,
                            .later = {frame_towards(b, down), frame_towards(c, down)}});
    input.spots.push_back({.position = c,
                           .axis = down.normalized(),
                           .intensity = Rgb(5.0f),
                           .cos_inner = 0.9f,
                           .cos_outer = 0.5f,
                           .radius_m = radius,
                           .later = {frame_towards(a, aside)}});
    input.directionals.push_back({.direction = down.normalized(),
                                  .irradiance = Rgb(0.5f),
                                  .angular_diameter_rad = radius,
                                  .later = {frame_towards(V3f(0.0f), aside)}});
    for (int i = 0; i < 5; ++i) // gives the tree a choice
      input.points.push_back({.position = V3f(static_cast<float>(i), 4, 0), .intensity = Rgb(0.5f)});
    const LightSet moving(input);
    const auto at = [&](float time) {
      LightSetInput still = input;
      still.points[0].position = time < 0.5f ? a + (b - a) * (2.0f * time) : b + (c - b) * (2.0f * time - 1.0f);
      still.spots[0].position = c + (a - c) * time;
      still.spots[0].axis = (down.normalized() * (1.0f - time) + aside.normalized() * time).normalized();
      still.directionals[0].direction = still.spots[0].axis;
      still.points[0].later.clear();
      still.spots[0].later.clear();
      still.directionals[0].later.clear();
      return still;
    };
    double mean = 0.0, error2 = 0.0;
    constexpr int kSlices = 32;
    for (int i = 0; i < kSlices; ++i) {
      const Estimate still = irradiance_at(
          LightSet(at((static_cast<float>(i) + 0.5f) / kSlices)), point, normal, [](size_t) { return 0.0f; }, 20'000,
          4);
      mean += still.mean() / kSlices;
      error2 += square(still.standard_error() / kSlices);
    }
    for (const float time : kTimes) {
      const Estimate now = irradiance_at(
          moving, point, normal, [&](size_t) { return time; }, 40'000, 1);
      const Estimate still = irradiance_at(
          LightSet(at(time)), point, normal, [](size_t) { return 0.0f; }, 40'000, 2);
      EXPECT_NEAR(now.mean(), still.mean(), 5.0 * std::hypot(now.standard_error(), still.standard_error())) << time;
      EXPECT_LE(now.standard_error(), 0.02 * now.mean());
    }
    // The mean over the shutter equals the mean of static lights; midpoints of 32 slices are
    // accurate to 1e-3 here.
    const Estimate all = irradiance_at(
        moving, point, normal, [](size_t i) { return (static_cast<float>(i) + 0.5f) / 200'000.0f; }, 200'000, 6);
    EXPECT_NEAR(all.mean(), mean, 5.0 * std::sqrt(square(all.standard_error()) + error2) + 1e-3 * mean) << radius;

    // Rays hit them at their positions.
    if (radius == 0.0f) continue;
    for (const float time : kTimes) {
      const V3f wi = (at(time).points[0].position - point).normalized();
      const ShapeRay ray{.origin = point, .normal = normal, .direction = wi, .end_m = 100.0f, .time = time};
      const LightSet still(at(time));
      EXPECT_GT(moving.shape_radiance(ray).x, 0.0f);
      EXPECT_NEAR(moving.shape_radiance(ray).x, still.shape_radiance(ray).x, 1e-3f * still.shape_radiance(ray).x);
      const ShapeRay up{.origin = point,
                        .normal = normal,
                        .direction = -at(time).directionals[0].direction,
                        .begin_m = 100.0f,
                        .time = time};
      EXPECT_NEAR(moving.shape_radiance(up).x, 0.5f * kInvPi / square(std::sin(0.15f)), 1e-3f);
    }
  }
}

TEST(MovingLights, PerLightSamplingHandlesMotion) {
  LightSetInput input = flock(0, 3);
  input.meshes = {{0, 3, "flock"}};
  const LightSet moving(input);
  const PerLightSampling whole(moving);
  const V3f point(0.3f, -0.5f, 0.2f), normal = V3f(0.2f, 1.0f, -0.3f).normalized();
  for (const float time : kTimes) {
    const LightSet still(frozen(input, time));
    test::Random random(3);
    Estimate a;
    for (int i = 0; i < 100'000; ++i) {
      const auto s = whole.sample(0, point, normal, random.next_2d(), time);
      a.add(s ? static_cast<double>(luminance(s->radiance) * s->wi.dot(normal) / s->pdf) : 0.0);
    }
    const Estimate b = irradiance_at(
        still, point, normal, [](size_t) { return 0.0f; }, 100'000, 2);
    EXPECT_NEAR(a.mean(), b.mean(), 5.0 * std::hypot(a.standard_error(), b.standard_error()) + 1e-9) << time;
  }
}

} // namespace
} // namespace kindling
