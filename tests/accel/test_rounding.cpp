// Tests of the error bounds of accel/rounding.h: valid, and small for well-shaped triangles.
// SPDX-License-Identifier: Apache-2.0
#include "accel/rounding.h"
#include "accel/triangle.h"
#include "tests/accel/accel_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Case {
  V3f origin, direction, p[3];
};

// Bounce rays of a room that leave the upper face of a skirting board 5 m long and 4 mm thick. They
// start 4 micrometers above its plane and go up, but the watertight test finds the plane 12 to 18
// micrometers ahead of them. A tree cell that ends at the plane lies behind the ray and is not
// entered; an accelerator that tests the triangle nevertheless reports a hit.
const Case kSkirting[] = {
    {{-2.19390368f, 0.110003747f, -1.25852215f},
     {-0.502367318f, 0.530064642f, -0.683124125f},
     {{-2.19400001f, 0.109999999f, -2.19400001f},
      {-2.19400001f, 0.109999999f, 2.99399996f},
      {-2.19000006f, 0.109999999f, 2.99399996f}}},
    {{-2.19248271f, 0.110003747f, -1.30380487f},
     {-0.457294583f, 0.613632441f, 0.64369005f},
     {{-2.19400001f, 0.109999999f, -2.19400001f},
      {-2.19000006f, 0.109999999f, 2.99399996f},
      {-2.19000006f, 0.109999999f, -2.19400001f}}},
};

// Single precision would place these slivers ahead; they are behind.
TEST(Rounding, SliversBehindTheOriginAreMissed) {
  for (const Case& c : kSkirting) {
    const TriangleJudgment judgment = judge_triangle(c.origin, c.direction, c.p[0], c.p[1], c.p[2]);
    EXPECT_LT(judgment.t, -5e-6); // behind the origin
    EXPECT_LT(judgment.t_error, 2e-3);
    EXPECT_TRUE(judgment.inside);

    Mesh mesh;
    mesh.add_triangle(c.p[0], c.p[1], c.p[2]);
    const TestScene scene(mesh);
    Ray ray;
    ray.origin = c.origin;
    ray.direction = c.direction;
    ray.t_max = kInfinity;
    for (const Kernels& kernels : all_kernels()) {
      const bool hit = build(kernels, scene)->intersect(ray).is_hit();
      EXPECT_FALSE(kernels.kind != Kind::embree && hit);
    }

    // Another implementation may report it, which is explained by rounding from nearby, but not
    // from farther away.
    Hit hit;
    hit.t = 2e-5f;
    hit.instance = hit.mesh = hit.triangle = 0;
    EXPECT_TRUE(is_possible_hit(scene.input(), ray, hit));
    EXPECT_TRUE(rounding_explains(scene.input(), ray, hit, Hit()));
    ray.origin = c.origin - c.direction * 0.01f;
    const Hit far = build(Kind::brute_force, scene)->intersect(ray);
    ASSERT_TRUE(far.is_hit());
    EXPECT_TRUE(is_possible_hit(scene.input(), ray, far));
    EXPECT_FALSE(rounding_explains(scene.input(), ray, far, Hit()));
    Hit wrong = far;
    wrong.t += 0.005f;
    EXPECT_FALSE(is_possible_hit(scene.input(), ray, wrong));
  }
}

// Returns a triangle with edge lengths from `length` down to `length * thin`, and a ray at a point
// of it, from a random side.
Case random_case(Rng& rng, float length, float thin, float away) {
  Case c;
  const V3f towards = uniform_direction(rng) * length;
  const V3f a = towards * uniform(rng, 0.0f, 5.0f), along = uniform_direction(rng), across = uniform_direction(rng);
  c.p[0] = a;
  c.p[1] = a + along * length;
  c.p[2] = a + along * (length * uniform(rng)) + across * (length * thin);
  std::rotate(c.p, c.p + rng() % 3, c.p + 3);
  float u = uniform(rng), v = uniform(rng);
  if (u + v > 1.0f) {
    u = 1.0f - u;
    v = 1.0f - v;
  }
  const V3f target = c.p[0] * (1.0f - u - v) + c.p[1] * u + c.p[2] * v;
  c.origin = target + uniform_direction(rng) * (length * away);
  c.direction = (target - c.origin) * std::pow(2.0f, uniform(rng, -4.0f, 4.0f));
  return c;
}

TEST(Rounding, ErrorBoundsHold) {
  Rng rng(211);
  int hits = 0, settled = 0, finite = 0;
  for (int i = 0; i < 400000; ++i) {
    const float exponents[] = {uniform(rng, -4.0f, 4.0f), uniform(rng, -6.0f, 0.0f), uniform(rng, -6.0f, 1.0f)};
    const Case c =
        random_case(rng, std::pow(10.0f, exponents[0]), std::pow(10.0f, exponents[1]), std::pow(10.0f, exponents[2]));
    if (c.direction == V3f(0) || !can_be_hit(c.p[0], c.p[1], c.p[2])) continue;
    const TriangleJudgment judgment = judge_triangle(c.origin, c.direction, c.p[0], c.p[1], c.p[2]);
    float t = 0.0f, u = 0.0f, v = 0.0f;
    const bool hit =
        intersect_triangle(RayShear(c.origin, c.direction), c.p[0], c.p[1], c.p[2], -kInfinity, kInfinity, t, u, v);
    if (!judgment.at_edge) {
      ASSERT_EQ(hit, judgment.inside) << i;
      ++settled;
    }
    if (!hit) continue;
    ++hits;
    if (judgment.t_error == std::numeric_limits<double>::infinity()) continue;
    ++finite;
    ASSERT_LE(std::fabs(t - judgment.t), judgment.t_error) << i;
  }
  EXPECT_GT(hits, 200000);
  EXPECT_GT(settled, 200000);
  EXPECT_GT(finite, 200000);
}

// A traversal enters the cells near a hit, so the triangle must be there: its point with the hit's
// barycentric coordinates, whose own rounding adds two units to the tolerance.
TEST(Rounding, HitsLieOnTheTriangle) {
  Rng rng(227);
  int hits = 0;
  double worst = 0.0;
  for (int i = 0; i < 1000000; ++i) {
    const float exponents[] = {uniform(rng, -4.0f, 4.0f), uniform(rng, -9.0f, 0.0f), uniform(rng, -7.0f, 3.0f)};
    Case c =
        random_case(rng, std::pow(10.0f, exponents[0]), std::pow(10.0f, exponents[1]), std::pow(10.0f, exponents[2]));
    if (i % 4 == 0) { // nearly edge-on, and beside an edge as well as inside
      const float by_first = uniform(rng, -2.0f, 2.0f), by_second = uniform(rng, -2.0f, 2.0f);
      const V3f along = (c.p[1] - c.p[0]) * by_first + (c.p[2] - c.p[0]) * by_second;
      c.direction = along + c.direction * std::pow(10.0f, uniform(rng, -8.0f, 0.0f));
    }
    if (c.direction == V3f(0) || !can_be_hit(c.p[0], c.p[1], c.p[2])) continue;
    const RayShear shear(c.origin, c.direction);
    float t = 0.0f, u = 0.0f, v = 0.0f;
    if (!intersect_triangle(shear, c.p[0], c.p[1], c.p[2], 0.0f, std::numeric_limits<float>::max(), t, u, v)) continue;
    ++hits;
    double extent = 0.0;
    for (int k = 0; k < 3; ++k)
      extent = std::max(extent, static_cast<double>(std::max({c.p[0][k], c.p[1][k], c.p[2][k]})) -
                                    std::min({c.p[0][k], c.p[1][k], c.p[2][k]}));
    for (int k = 0; k < 3; ++k) {
      const double on_ray = c.origin[k] + static_cast<double>(t) * c.direction[k];
      const double on_triangle = c.p[0][k] + static_cast<double>(u) * (static_cast<double>(c.p[1][k]) - c.p[0][k]) +
                                 static_cast<double>(v) * (static_cast<double>(c.p[2][k]) - c.p[0][k]);
      const double tolerance = (kExtentTolerance + 0x1p-23) * extent +
                               kDistanceTolerance * std::fabs(static_cast<double>(t) * c.direction[k]);
      ASSERT_LE(std::fabs(on_ray - on_triangle), tolerance) << i << " axis " << k;
      worst = std::max(worst, std::fabs(on_ray - on_triangle) / tolerance);
    }
  }
  EXPECT_GT(hits, 200000);
  EXPECT_GT(worst, 0.05); // else the tolerance is needlessly large
}

// For well-shaped triangles the bound is the rounding of the vertices, seen at the angle of the
// ray.
TEST(Rounding, ErrorIsSmallForWellShapedTriangles) {
  Rng rng(223);
  for (int i = 0; i < 20000; ++i) {
    Case c;
    const V3f normal = uniform_direction(rng);
    V3f side = uniform_direction(rng).cross(normal);
    if (side.length() < 0.1f) continue;
    side.normalize();
    const V3f other = normal.cross(side), center = uniform_direction(rng) * 3.0f;
    for (int k = 0; k < 3; ++k) {
      const float angle = 2.0943951f * static_cast<float>(k);
      c.p[k] = center + side * std::cos(angle) + other * std::sin(angle);
    }
    const V3f towards = uniform_direction(rng);
    c.origin = center + towards * uniform(rng, 0.01f, 10.0f);
    c.direction = (center - c.origin).normalized();
    const float cosine = std::fabs(c.direction.dot(normal));
    if (cosine < 0.01f) continue;
    float extent = 0.0f;
    for (const V3f& p : c.p) extent = std::max(extent, (p - c.origin).length());
    const TriangleJudgment judgment = judge_triangle(c.origin, c.direction, c.p[0], c.p[1], c.p[2]);
    EXPECT_TRUE(judgment.inside && !judgment.at_edge);
    EXPECT_LE(judgment.t_error, 64.0 * 0x1p-24 * extent / cosine);
  }
}

} // namespace
} // namespace kindling::accel::testing
