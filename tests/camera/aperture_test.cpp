// Tests of apertures: uniformity over known shapes by chi-square, and stratification.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/aperture.h"

#include "renderer/base/hash.h"

#include "tests/sampling/chi_square.h"

#include <gtest/gtest.h>

namespace kindling {
namespace {

using test::Random;

constexpr float kRadius = 0.02f;

CameraLens lens_of(int blades, float rotation, float ratio, float cats_eye) {
  CameraLens lens;
  lens.aperture_blades = blades;
  lens.aperture_rotation_rad = rotation;
  lens.anamorphic_ratio = ratio;
  lens.cats_eye = cats_eye;
  return lens;
}

// Returns the area of the intersection of two disks of radius 1 whose centers are `distance` apart.
double common_area(double distance) {
  return 2.0 * std::acos(0.5 * distance) - 0.5 * distance * std::sqrt(4.0 - distance * distance);
}

struct Shape {
  CameraLens lens;
  V2f field;
  double area; // on the unit circle's scale, with the ratio; 0: not known in closed form
};

std::vector<Shape> shapes() {
  const auto polygon = [](int n) { return 0.5 * n * std::sin(2.0 * std::numbers::pi / n); };
  const double pi = std::numbers::pi;
  return {{lens_of(0, 0.0f, 1.0f, 0.0f), V2f(0.7f, 0.1f), pi},
          {lens_of(3, 0.0f, 1.0f, 0.0f), V2f(0.0f), polygon(3)},
          {lens_of(5, 0.4f, 1.0f, 0.0f), V2f(0.0f), polygon(5)},
          {lens_of(6, -50.0f, 1.5f, 0.0f), V2f(0.0f), polygon(6) / 1.5},
          {lens_of(64, 1.0f, 0.5f, 0.0f), V2f(0.0f), polygon(64) / 0.5},
          {lens_of(0, 0.0f, 1.0f, 0.5f), V2f(0.6f, -0.8f), common_area(0.5)},
          {lens_of(0, 0.0f, 2.0f, 1.0f), V2f(-0.8f, 0.6f), common_area(1.0) / 2.0},
          {lens_of(0, 0.0f, 1.0f, 1.0f), V2f(0.3f, 0.4f), common_area(0.5)},
          {lens_of(7, 0.2f, 1.0f, 0.8f), V2f(0.0f, 1.0f), 0.0}};
}

// Bins of a grid; expectations are the counts of interior points among 64 x 64 per cell.
TEST(Aperture, IsSampledUniformly) {
  const std::vector<Shape> all = shapes();
  const double level = test::sidak_level(0.01, static_cast<int>(all.size()));
  constexpr int kGrid = 24, kInside = 64, kSamples = 100000;
  for (size_t k = 0; k < all.size(); ++k) {
    const Aperture aperture(all[k].lens, kRadius);
    const double extent = kRadius * std::max(1.0, 1.0 / static_cast<double>(all[k].lens.anamorphic_ratio)) * 1.0001;
    std::vector<double> expected(kGrid * kGrid, 0.0), observed(kGrid * kGrid, 0.0);
    double area = 0.0;
    for (int y = 0; y < kGrid * kInside; ++y)
      for (int x = 0; x < kGrid * kInside; ++x) {
        const auto at = [&](int i) { return static_cast<float>(((i + 0.5) / (kGrid * kInside) * 2.0 - 1.0) * extent); };
        if (!aperture.contains(V2f(at(x), at(y)), all[k].field)) continue;
        expected[static_cast<size_t>(y / kInside * kGrid + x / kInside)] += 1.0;
        area += 1.0;
      }
    const double cell_area = 4.0 * extent * extent / square(kGrid * kInside) / square(kRadius);
    if (all[k].area > 0.0) {
      EXPECT_NEAR(area * cell_area, all[k].area, 2e-3 * all[k].area) << k;
    }
    for (double& e : expected) e *= kSamples / area;
    Random random(k + 1);
    for (int i = 0; i < kSamples; ++i) {
      const V2f p = aperture.sample(random.next_2d(), all[k].field);
      ASSERT_TRUE(aperture.contains(p, all[k].field)) << k << ": " << p.x << " " << p.y;
      const auto cell = [&](float v) {
        return static_cast<int>((static_cast<double>(v) / extent * 0.5 + 0.5) * kGrid);
      };
      observed[static_cast<size_t>(cell(p.y) * kGrid + cell(p.x))] += 1.0;
    }
    double statistic = 0.0, pooled_expected = 0.0, pooled_observed = 0.0;
    int cells = 0;
    const auto close = [&](double e, double o) {
      statistic += (o - e) * (o - e) / e;
      ++cells;
    };
    for (size_t i = 0; i < expected.size(); ++i) {
      if (expected[i] >= 40.0) { // edges are only accurate to a percent
        close(expected[i], observed[i]);
      } else {
        pooled_expected += expected[i];
        pooled_observed += observed[i];
      }
    }
    if (pooled_expected >= 8.0) close(pooled_expected, pooled_observed);
    const double p_value = test::chi_square_tail(statistic, cells - 1);
    EXPECT_GT(p_value, level) << "shape " << k << ": chi-square " << statistic << " with " << cells - 1;
  }
}

// The whole aperture, of which the barrel hides a part.
TEST(Aperture, AreaRatioHasItsMean) {
  for (const Shape& shape : shapes()) {
    const Aperture aperture(shape.lens, kRadius);
    CameraLens open = shape.lens;
    open.cats_eye = 0.0f;
    const Aperture whole(open, kRadius);
    Random random(9);
    constexpr uint32_t kCount = 100000;
    double sum = 0.0, squares = 0.0, visible = 0.0;
    for (uint32_t i = 0; i < kCount; ++i) {
      const auto ratio = static_cast<double>(aperture.area_ratio(hash_u32(i), shape.field));
      ASSERT_GE(ratio, 1.0);
      sum += ratio;
      squares += ratio * ratio;
      const V2f point = whole.sample(random.next_2d(), V2f(0.0f));
      visible += aperture.hides(point, shape.field) ? 0.0 : 1.0;
    }
    const double mean = sum / kCount, share = visible / kCount;
    const double error = std::sqrt((squares / kCount - mean * mean) / kCount);
    const double error_of_share = std::sqrt(share * (1.0 - share) / kCount) / (share * share);
    EXPECT_NEAR(mean, 1.0 / share, 4.5 * std::hypot(error, error_of_share) + 1e-9);
    if (shape.lens.cats_eye == 0.0f) {
      EXPECT_EQ(mean, 1.0);
    }
  }
}

// A corner at the top, then counterclockwise by the rotation; the ratio narrows it.
TEST(Aperture, CornersMatchRotationAndRatio) {
  const auto has_corner = [](const Aperture& aperture, float x, float y) {
    return aperture.contains(V2f(x, y) * (0.999f * kRadius), V2f(0.0f)) &&
           !aperture.contains(V2f(x, y) * (1.001f * kRadius), V2f(0.0f));
  };
  const Aperture triangle(lens_of(3, 0.0f, 1.0f, 0.0f), kRadius);
  EXPECT_TRUE(has_corner(triangle, 0.0f, 1.0f));
  EXPECT_FALSE(triangle.contains(V2f(0.0f, -0.6f * kRadius), V2f(0.0f))); // below the middle of the edge
  const float half = 0.5f * std::sqrt(3.0f);
  EXPECT_TRUE(has_corner(triangle, half, -0.5f));
  const Aperture turned(lens_of(3, kPi / 6.0f, 1.0f, 0.0f), kRadius);
  EXPECT_TRUE(has_corner(turned, -0.5f, half));
  const Aperture narrow(lens_of(3, 0.0f, 2.0f, 0.0f), kRadius);
  EXPECT_TRUE(has_corner(narrow, 0.0f, 1.0f));
  EXPECT_TRUE(has_corner(narrow, 0.5f * half, -0.5f));
}

// The first 4^k points of a stratified set fall one into each cell of equal area, within the limits
// of cell corners; tested by triangles.
TEST(Aperture, PreservesStrata) {
  const Aperture square_hole(lens_of(4, 0.0f, 1.0f, 0.0f), 1.0f);
  constexpr int kSide = 8;
  std::array<int, 4> counts{};
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const V2f p =
          square_hole.sample(V2f(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.25f) / kSide, V2f(0.0f));
      ++counts[static_cast<size_t>((p.x > 0.0f ? 1 : 0) + (p.y > 0.0f ? 2 : 0))];
    }
  for (const int count : counts) EXPECT_EQ(count, kSide * kSide / 4);
}

TEST(Aperture, IsPureFunction) {
  const Aperture aperture(lens_of(5, 0.1f, 1.2f, 1.0f), kRadius);
  for (const V2f& u : {V2f(0.0f), V2f(kOneMinusEpsilon), V2f(0.5f), V2f(0.5f, 0.0f), V2f(0.99f, 0.01f)}) {
    const V2f p = aperture.sample(u, V2f(0.6f, 0.8f));
    EXPECT_EQ(p, aperture.sample(u, V2f(0.6f, 0.8f)));
    EXPECT_TRUE(aperture.contains(p, V2f(0.6f, 0.8f)));
  }
}

} // namespace
} // namespace kindling
