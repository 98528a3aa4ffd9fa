// Every strategy on scenes with closed-form radiance.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"
#include "tests/light/light_fixtures.h"
#include "tests/unbiased/render_images.h"

#include <cstdio>

namespace kindling::test {
namespace {

struct KnownScene {
  Scene scene;
  std::shared_ptr<const Environment> environment;
  Camera camera; // 16 x 16 pixels, all of which see `expected`
  int max_bounces = 0;
  uint32_t samples = 8; // per pixel and seed
  double expected = 0.0;
};

void expect_by_every_strategy(const KnownScene& known) {
  constexpr uint32_t kSeeds = 36;
  constexpr double kRounding = 2e-5; // relative error of floats, as in closed_form_test.cpp
  const Family family{1e-5, 2 * strategy_count(false, false)};
  const double threshold = family.whole_threshold();
  constexpr double kPowerMargin = 1.2816; // quantile of a normal distribution for a power of 0.9
  for (const Strategy& strategy : kStrategies) {
    if (strategy.for_casters) continue;
    const auto world = make_world(known.scene, strategy.accelerator, known.environment);
    RenderSettings settings = base_settings(known.camera.size_px(), known.max_bounces, known.samples);
    const auto guide = strategy.guided ? train_one_guide(*world, known.camera, settings) : nullptr;
    strategy.apply(settings);
    const Images images = render_images(*world, known.camera, settings, 0, kSeeds, guide.get());
    const std::vector<double> expected(kSeeds, known.expected);
    const Difference difference = paired_difference_of(images.whole(), expected);
    std::printf("  %-24s %+.4f %% +- %.4f %%, z %+.2f\n", strategy.name, 100.0 * difference.value / known.expected,
                100.0 * difference.standard_error / known.expected, difference.z());
    const double beyond_rounding = std::max(std::fabs(difference.value) - kRounding * known.expected, 0.0);
    EXPECT_LT(difference.normal_score(beyond_rounding), threshold) << strategy.name;
    EXPECT_GT(difference.normal_score(Verdict::kBias * known.expected), threshold + kPowerMargin)
        << strategy.name << " is too noisy";
  }
}

// Inside a closed sphere that emits L and reflects rho: L (1 + rho + ... + rho^(n + 1)) after n + 1
// reflections.
TEST(KnownAnswers, ClosedSphere) {
  const float rho = 0.6f, emitted = 0.7f;
  SceneCamera pinhole;
  pinhole.yfov_rad = 1.5f;
  const int bounces = 3;
  double expected = 0.0;
  for (int k = 0; k <= bounces + 1; ++k) expected += emitted * std::pow(rho, k);
  expect_by_every_strategy(
      {make_scene({emissive_material(Rgb(emitted), Rgb(rho))}, {sphere(V3f(0.0f), 1.0f, 24, 0, false)}), nullptr,
       Camera(pinhole, look_at(V3f(0.2f, 0.1f, 0.0f), V3f(0, 0.3f, -1)), V2i(16, 16)), bounces, 8, expected});
}

// Returns the form factor from a point to a parallel rectangle [0, x] x [0, y] at distance 1,
// signed as x y (Howell, Menguec, Daun, Siegel, "Thermal Radiation Heat Transfer", configuration
// factor B-3).
double corner_form_factor(double x, double y) {
  return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
          y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
         (2.0 * std::numbers::pi);
}

// A hundred rectangles of different size and radiance above a diffuse floor: form factors add up.
TEST(KnownAnswers, ManyRectangles) {
  const float rho = 0.5f, height = 1.5f;
  Random random(5);
  std::vector<Material> materials{diffuse_material(Rgb(rho))};
  std::vector<Primitive> primitives{quad(V3f(-9, 0, 9), V3f(18, 0, 0), V3f(0, 0, -18), 0)};
  double irradiance = 0.0;
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) {
      const float x0 = -4.0f + 0.8f * static_cast<float>(i), z0 = -4.0f + 0.8f * static_cast<float>(j);
      const float width = 0.2f + 0.5f * random.next_1d(), depth = 0.2f + 0.5f * random.next_1d();
      const float radiance = 0.5f + 3.0f * random.next_1d();
      primitives.push_back(
          quad(V3f(x0, height, z0), V3f(width, 0, 0), V3f(0, 0, depth), static_cast<int>(materials.size())));
      materials.push_back(emissive_material(Rgb(radiance)));
      const double left = x0 / height, right = (x0 + width) / height;
      const double back = z0 / height, front = (z0 + depth) / height;
      irradiance += radiance * std::numbers::pi *
                    (corner_form_factor(right, front) - corner_form_factor(left, front) -
                     corner_form_factor(right, back) + corner_form_factor(left, back));
    }
  expect_by_every_strategy({make_scene(std::move(materials), std::move(primitives)), nullptr,
                            beam_camera(V3f(6, 0.8f, 0), V3f(0.0f), 1e-3f, V2i(16, 16)), 0, 12,
                            rho * irradiance / std::numbers::pi});
}

// A diffuse plane under a uniform sky, and under one that is brightest around a zenith angle of 45
// degrees. Rows of the environment are interpolated linearly, so the irradiance is an integral over
// the zenith angle alone.
TEST(KnownAnswers, PlaneUnderASky) {
  const float rho = 0.8f;
  constexpr int kRows = 16;
  const auto level = [](int row) { return row == 3 || row == 4 ? 2.0f : row < 8 ? 0.5f : 1.0f; };
  const auto rings = float_image(2 * kRows, kRows, [&](int, int y) { return Rgb(level(y)); });
  double irradiance = 0.0;
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) {
    const double theta = (i + 0.5) / kSteps * 0.5 * std::numbers::pi, row = theta / std::numbers::pi * kRows - 0.5;
    const int above = static_cast<int>(std::floor(row));
    const double fraction = row - above;
    const double radiance = (1.0 - fraction) * level(std::max(above, 0)) + fraction * level(above + 1);
    irradiance +=
        radiance * std::cos(theta) * std::sin(theta) * 2.0 * std::numbers::pi * 0.5 * std::numbers::pi / kSteps;
  }
  const Scene plane = make_scene({diffuse_material(Rgb(rho))}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0)});
  const Camera camera = beam_camera(V3f(1, 2, 1), V3f(0.0f), 0.1f, V2i(16, 16));
  expect_by_every_strategy({plane, std::make_shared<Environment>(Rgb(0.7f)), camera, 0, 24, rho * 0.7f});
  expect_by_every_strategy(
      {plane, std::make_shared<Environment>(rings, 0.3f, 1.0f), camera, 0, 24, rho * irradiance / std::numbers::pi});
}

// A lamp behind two veils, which attenuate shadow rays and BSDF rays by their coverage.
TEST(KnownAnswers, Veils) {
  const float rho = 0.5f, emitted = 3.0f;
  std::vector<Material> materials{diffuse_material(Rgb(rho)), emissive_material(Rgb(emitted))};
  for (const float alpha : {0.1f, 0.2f}) {
    Material veil = diffuse_material(Rgb(0.0f));
    veil.base_color_factor.w = alpha;
    veil.alpha_mode = AlphaMode::blend;
    materials.push_back(veil);
  }
  const std::vector<Primitive> primitives{
      quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0), quad(V3f(-1, 1, -0.5f), V3f(2, 0, 0), V3f(0, 0, 1), 1),
      quad(V3f(-2, 0.9f, -2), V3f(4, 0, 0), V3f(0, 0, 4), 2), quad(V3f(-2, 0.7f, -2), V3f(4, 0, 0), V3f(0, 0, 4), 3)};
  const double reflected = rho * emitted * 4.0 * corner_form_factor(1.0, 0.5) * 0.9 * 0.8;
  expect_by_every_strategy({make_scene(materials, primitives), nullptr,
                            beam_camera(V3f(3, 0.5f, 0), V3f(0.0f), 1e-3f, V2i(16, 16)), 0, 48, reflected});
}

} // namespace
} // namespace kindling::test
