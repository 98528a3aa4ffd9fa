// Tests of warps against their densities, and of spherical triangles against exact solid angles.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/spherical_triangle.h"
#include "renderer/sampling/warp.h"

#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace kindling {
namespace {

using test::ChiSquareOptions;
using test::ChiSquareResult;
using test::Random;
using test::Rect;

using Point = std::array<double, 2>;

constexpr int kWarpChecks = 25;
const double kLevel = test::sidak_level(0.01, kWarpChecks);

void expect_pass(const ChiSquareResult& result, double integral_tolerance = 1e-4) {
  EXPECT_GT(result.p_value, kLevel) << result.summary;
  EXPECT_NEAR(result.integral, 1.0, integral_tolerance) << result.summary;
}

TEST(WarpStatistical, UniformDisk) {
  const auto draw = [](Random& random) -> std::optional<Point> {
    const V2f p = sample_uniform_disk(random.next_2d());
    return Point{p.x, p.y};
  };
  const auto density = [](double x, double y) {
    return static_cast<double>(uniform_disk_pdf({static_cast<float>(x), static_cast<float>(y)}));
  };
  expect_pass(test::chi_square_test({-1.0, 1.0, -1.0, 1.0}, draw, density, {.seed = 1}), 1e-3);
}

TEST(WarpStatistical, CosineHemisphere) {
  expect_pass(
      test::chi_square_hemisphere([](Random& r) -> std::optional<V3f> { return sample_cosine_hemisphere(r.next_2d()); },
                                  cosine_hemisphere_pdf, {.seed = 2}));
}

TEST(WarpStatistical, UniformHemisphere) {
  expect_pass(test::chi_square_hemisphere(
                  [](Random& r) -> std::optional<V3f> { return sample_uniform_hemisphere(r.next_2d()); },
                  uniform_hemisphere_pdf, {.seed = 3}),
              1e-3);
}

TEST(WarpStatistical, UniformSphere) {
  expect_pass(
      test::chi_square_sphere([](Random& r) -> std::optional<V3f> { return sample_uniform_sphere(r.next_2d()); },
                              uniform_sphere_pdf, {.seed = 4}));
}

TEST(WarpStatistical, UniformCone) {
  uint64_t seed = 5;
  for (const float aperture : {1.0f - std::cos(0.00465f), 1e-3f, 0.3f, 1.0f}) { // the first is that of the sun
    expect_pass(test::chi_square_hemisphere(
                    [&](Random& r) -> std::optional<V3f> { return sample_uniform_cone(r.next_2d(), aperture); },
                    [&](const V3f& w) { return uniform_cone_pdf(w, aperture); }, {.seed = seed++}),
                1e-3);
  }
  const float wide = 1.7f;
  expect_pass(
      test::chi_square_sphere([&](Random& r) -> std::optional<V3f> { return sample_uniform_cone(r.next_2d(), wide); },
                              [&](const V3f& w) { return uniform_cone_pdf(w, wide); }, {.seed = seed}),
      1e-3);
}

TEST(WarpStatistical, EvenCone) {
  uint64_t seed = 65;
  for (const float aperture : {1.0f - std::cos(0.00465f), 1e-3f, 0.3f, 1.0f}) {
    expect_pass(test::chi_square_hemisphere(
                    [&](Random& r) -> std::optional<V3f> { return sample_even_cone(r.next_2d(), aperture); },
                    [&](const V3f& w) { return uniform_cone_pdf(w, aperture); }, {.seed = seed++}),
                1e-3);
  }
}

TEST(WarpStatistical, HenyeyGreenstein) {
  uint64_t seed = 40;
  for (const float g : {-0.7f, 0.0f, 5e-4f, 0.3f, 0.95f}) {
    expect_pass(test::chi_square_sphere(
                    [&](Random& r) -> std::optional<V3f> { return sample_henyey_greenstein(r.next_2d(), g); },
                    [&](const V3f& w) { return henyey_greenstein_pdf(w, g); }, {.seed = seed++}),
                1e-3);
    double mean_cosine = 0.0; // at midpoints of u.x; equals g for any azimuth
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i)
      mean_cosine += sample_henyey_greenstein({(static_cast<float>(i) + 0.5f) / kSteps, 0.3f}, g).z / kSteps;
    EXPECT_NEAR(mean_cosine, g, 6e-4); // g is treated as 0 if |g| <= 1e-3
  }
}

TEST(WarpStatistical, UniformTriangle) {
  const V3f p0(1.0f, 2.0f, 0.0f);
  const V3f p1(4.0f, 2.5f, 0.0f);
  const V3f p2(2.0f, 5.0f, 0.0f);
  const auto draw = [&](Random& random) -> std::optional<Point> {
    const V2f b = sample_uniform_triangle(random.next_2d());
    const V3f p = p0 * (1.0f - b.x - b.y) + p1 * b.x + p2 * b.y;
    return Point{p.x, p.y};
  };
  const auto density = [&](double x, double y) {
    const V3f p(static_cast<float>(x), static_cast<float>(y), 0.0f);
    const bool inside =
        (p1 - p0).cross(p - p0).z >= 0 && (p2 - p1).cross(p - p1).z >= 0 && (p0 - p2).cross(p - p2).z >= 0;
    return inside ? static_cast<double>(uniform_triangle_pdf(p0, p1, p2)) : 0.0;
  };
  expect_pass(test::chi_square_test({1.0, 4.0, 2.0, 5.0}, draw, density, {.seed = 10}), 1e-3);
}

struct TriangleCase {
  const char* name;
  V3f p[3];
  V3f reference;
};
// Triangles of several steradians down to a trillionth.
const TriangleCase kTriangles[] = {
    {"moderate", {{1, 0, 3}, {-2, 1, 2}, {0, 2, 4}}, {0, 0, 0}},
    {"huge", {{4, 1, 1}, {-10, 3, 3}, {-2, -8, 10}}, {0.5f, -0.4f, 0.7f}},
    {"surrounding", {{10, 0, 0.5f}, {-8, 9, 0.5f}, {-8, -9, 0.5f}}, {0, 0, 0.4f}},
    {"grazing", {{1, 0, 0}, {3, 0.5f, 0}, {2, 3, 0}}, {0, 0, 0.01f}},
    {"sliver", {{1, 0, 1}, {1.001f, 0.0001f, 1}, {0, 2, 1}}, {0, 0, 0}},
    {"small", {{1000, 0, 1000}, {1000.5f, 0.5f, 1000}, {1000, 1, 1000.5f}}, {0, 0, 0}},
    {"tiny", {{1, 1, 1}, {1.000001f, 1, 1}, {1, 1.000001f, 1.0000005f}}, {0, 0, 0}},
    {"reversed", {{0, 2, 4}, {-2, 1, 2}, {1, 0, 3}}, {0, 0, 0}},
};

// Returns the density per unit of the barycentric plane: pdf times d(solid angle) /
// d(barycentrics), in double precision.
double barycentric_density(const TriangleCase& t, double pdf, double b1, double b2) {
  if (b1 < 0.0 || b2 < 0.0 || b1 + b2 > 1.0) return 0.0;
  const V3d p0(t.p[0]);
  const V3d e1 = V3d(t.p[1]) - p0;
  const V3d e2 = V3d(t.p[2]) - p0;
  const V3d d = p0 + e1 * b1 + e2 * b2 - V3d(t.reference);
  return pdf * std::abs(e1.cross(e2).dot(d)) / (d.length2() * d.length());
}

// The density in barycentrics integrates to 1 and matches the samples: barycentrics, solid angle
// and pdf are consistent.
TEST(WarpStatistical, SphericalTriangle) {
  uint64_t seed = 20;
  for (const TriangleCase& t : kTriangles) {
    const SphericalTriangle triangle(t.p[0], t.p[1], t.p[2], t.reference);
    const double pdf = static_cast<double>(triangle.pdf());
    const auto draw = [&](Random& random) -> std::optional<Point> {
      const V2f b = triangle.sample(random.next_2d()).barycentrics;
      return Point{b.x, b.y};
    };
    const ChiSquareResult result = test::chi_square_test(
        {0.0, 1.0, 0.0, 1.0}, draw, [&](double b1, double b2) { return barycentric_density(t, pdf, b1, b2); },
        {.seed = seed++});
    EXPECT_GT(result.p_value, kLevel) << t.name << ": " << result.summary;
    EXPECT_NEAR(result.integral, 1.0, 1e-3) << t.name;
  }
}

TEST(Warp, SphericalTriangleSamplesLieInsideAndAgreeWithTheirDirections) {
  for (const TriangleCase& t : kTriangles) {
    const SphericalTriangle triangle(t.p[0], t.p[1], t.p[2], t.reference);
    Random random(7);
    for (int i = 0; i < 20000; ++i) {
      V2f u = random.next_2d();
      if (i % 16 == 0) u.x = i % 32 == 0 ? 0.0f : kOneMinusEpsilon;
      if (i % 16 == 1) u.y = i % 32 == 1 ? 0.0f : kOneMinusEpsilon;
      const SphericalTriangle::Sample s = triangle.sample(u);
      ASSERT_TRUE(s.barycentrics.x >= 0.0f && s.barycentrics.y >= 0.0f &&
                  s.barycentrics.x + s.barycentrics.y <= 1.00001f)
          << t.name << " " << s.barycentrics;
      const V3f p =
          t.p[0] * (1.0f - s.barycentrics.x - s.barycentrics.y) + t.p[1] * s.barycentrics.x + t.p[2] * s.barycentrics.y;
      const V3f expected = (p - t.reference).normalized();
      ASSERT_LT((expected - s.direction).length(), 2e-5f) << t.name;
      ASSERT_NEAR(s.direction.length(), 1.0f, 1e-6f);
    }
  }
}

TEST(Warp, SolidAngleOfAnOctantIsExact) {
  const SphericalTriangle octant({1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {0, 0, 0});
  EXPECT_NEAR(octant.solid_angle(), 0.5f * kPi, 1e-6f);
  EXPECT_NEAR(octant.pdf(), 2.0f * kInvPi, 1e-6f);
  // At a large distance the solid angle is area times cosine over the squared distance.
  const SphericalTriangle far({0, 0, 1000}, {1, 0, 1000}, {0, 1, 1000}, {0, 0, 0});
  EXPECT_NEAR(far.solid_angle(), 0.5e-6f, 1e-11f);
}

TEST(Warp, DegenerateTrianglesHaveNoDensity) {
  EXPECT_EQ(SphericalTriangle({1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}).pdf(), 0.0f); // no area
  EXPECT_EQ(SphericalTriangle({1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 0}).pdf(), 0.0f); // edge-on
  EXPECT_EQ(SphericalTriangle({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}).pdf(), 0.0f); // seen from its corner
  EXPECT_EQ(uniform_triangle_pdf({1, 0, 0}, {2, 0, 0}, {3, 0, 0}), 0.0f);
  EXPECT_FLOAT_EQ(uniform_triangle_pdf({0, 0, 0}, {2, 0, 0}, {0, 3, 0}), 1.0f / 3.0f);
}

TEST(Warp, DirectionsAreUnit) {
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const V2f u = random.next_2d();
    for (const V3f& w : {sample_cosine_hemisphere(u), sample_uniform_hemisphere(u), sample_uniform_sphere(u),
                         sample_uniform_cone(u, 0.2f)}) {
      ASSERT_NEAR(w.length(), 1.0f, 5e-7f);
    }
  }
}

TEST(Warp, SincosIsAccurateOverManyTurns) {
  Random random(8);
  double worst = 0.0;
  for (int i = 0; i < 1000000; ++i) {
    const float turns = (random.next_1d() - 0.25f) * (i % 2 == 0 ? 1.0f : 8.0f);
    const SinCos s = sincos_turns(turns);
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(turns);
    worst = std::max({worst, std::abs(static_cast<double>(s.sin) - std::sin(angle)),
                      std::abs(static_cast<double>(s.cos) - std::cos(angle))});
  }
  EXPECT_LT(worst, 1.5e-7);
}

// Continuity preserves the strata of the sampler.
TEST(Warp, DiskMapIsContinuousAndCoversTheCenter) {
  EXPECT_EQ(sample_uniform_disk({0.5f, 0.5f}), V2f(0.0f, 0.0f));
  Random random(9);
  for (int i = 0; i < 100000; ++i) {
    const V2f u = random.next_2d();
    const V2f v(std::min(u.x + 1e-3f, kOneMinusEpsilon), u.y);
    ASSERT_LT((sample_uniform_disk(u) - sample_uniform_disk(v)).length(), 4e-3f);
  }
}

} // namespace
} // namespace kindling
