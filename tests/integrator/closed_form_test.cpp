// The path tracer with every accelerator on scenes with closed-form solutions.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

namespace kindling::test {
namespace {

// Two-sided level of 5e-6 for each comparison, and room for float rounding.
void expect_mean(const Mean& mean, double expected) {
  EXPECT_NEAR(mean.luminance, expected, 4.5 * mean.standard_error + 2e-5 * expected)
      << "standard error " << mean.standard_error;
}

class ClosedForm : public testing::TestWithParam<accel::Kind> {
 public:
  // A closed sphere of flat faces that emits and reflects, and a camera inside of it.
  struct Furnace {
    float emitted, rho;
    int slices, side_px;
  };
  // Returns the mean of an image of it with so many samples.
  [[nodiscard]] static Mean mean_inside(const Furnace& furnace, uint32_t samples, auto change_settings) {
    const auto world = make_world(make_scene({emissive_material(Rgb(furnace.emitted), Rgb(furnace.rho))},
                                             {sphere(V3f(0.0f), 1.0f, furnace.slices, 0, false)}),
                                  GetParam());
    const V2i size(furnace.side_px, furnace.side_px);
    SceneCamera pinhole;
    pinhole.yfov_rad = 1.5f;
    const Camera camera(pinhole, look_at(V3f(0.2f, 0.1f, 0.0f), V3f(0, 0.3f, -1)), size);
    RenderSettings settings = small_render(size, samples);
    change_settings(settings.integrator);
    return render_mean(*world, camera, settings);
  }
  // Returns the radiance inside after so many bounces of each path.
  [[nodiscard]] static double radiance_inside(const Furnace& furnace, int bounces) {
    double sum = 0.0;
    for (int k = 0; k <= bounces + 1; ++k) sum += furnace.emitted * std::pow(furnace.rho, k);
    return sum;
  }
};

// Both furnaces have flat normals: geometry and shading agree, so the solutions are exact. After
// n + 1 reflections inside a closed sphere that emits L and reflects rho, radiance is
// L (1 + rho + ... + rho^(n + 1)).
TEST_P(ClosedForm, SphereInsideAFurnace) {
  const Furnace furnace{.emitted = 0.7f, .rho = 0.6f, .slices = 24, .side_px = 16};
  for (const int bounces : {0, 1, 5})
    expect_mean(mean_inside(furnace, 64, [&](IntegratorSettings& s) { s.max_bounces = bounces; }),
                radiance_inside(furnace, bounces));
}

// A limit on diffuse bounces ends paths before the limit on all of them, however large it is.
TEST_P(ClosedForm, HundredsOfDiffuseBounces) {
  const Furnace furnace{.emitted = 0.01f, .rho = 0.99f, .slices = 16, .side_px = 8};
  const auto limits = [](IntegratorSettings& s) {
    s.max_bounces = 400;
    s.max_diffuse_bounces = 300;
    s.roulette_start_bounce = kMaxBounces;
  };
  expect_mean(mean_inside(furnace, 16, limits), radiance_inside(furnace, 300));
}

// A point under the corner of a parallel rectangle a x b at height h sees it with the form factor
// (X / sqrt(1 + X^2) atan(Y / sqrt(1 + X^2)) + Y / sqrt(1 + Y^2) atan(X / sqrt(1 + Y^2))) / (2 pi),
// X = a / h, Y = b / h (Howell, Menguec, Daun, Siegel, "Thermal Radiation Heat Transfer",
// configuration factor B-3).
double corner_form_factor(double a, double b, double h) {
  const double x = a / h, y = b / h;
  return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
          y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
         (2.0 * std::numbers::pi);
}

TEST_P(ClosedForm, DiffusePlateUnderARectangularLight) {
  const float rho = 0.5f, emitted = 3.0f;
  // Light 2 x 1 at height 1, facing down; plate at y = 0. The point under its center sees four
  // corner rectangles 1 x 0.5.
  const auto world = make_world(make_scene({diffuse_material(Rgb(rho)), emissive_material(Rgb(emitted))},
                                           {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                            quad(V3f(-1, 1, -0.5f), V3f(2, 0, 0), V3f(0, 0, 1), 1)}),
                                GetParam());
  const Camera camera = beam_camera(V3f(3, 0.8f, 0), V3f(0.0f), 1e-3f);
  RenderSettings settings = small_render(V2i(8, 8), 256);
  settings.integrator.max_bounces = 0;
  expect_mean(render_mean(*world, camera, settings), rho * emitted * 4.0 * corner_form_factor(1.0, 0.5, 1.0));
}

// A lamp 10 cm, 1 mm and 0.1 mm below the ceiling lights it beside itself at grazing angles, at
// coordinates far from the origin: offsets of shadow rays must not cause self-shadowing.
TEST_P(ClosedForm, CeilingBesideALamp) {
  const float rho = 0.5f, emitted = 20.0f;
  for (const float gap : {0.1f, 1e-3f, 1e-4f}) {
    const V3f corner(5.0f, 5.5f - gap, -3.0f);
    const auto world = make_world(make_scene({diffuse_material(Rgb(rho)), emissive_material(Rgb(emitted))},
                                             {quad(V3f(0, 5.5f, -8), V3f(10, 0, 0), V3f(0, 0, 10), 0),
                                              quad(corner, V3f(1, 0, 0), V3f(0, 0, 1), 1)}),
                                  GetParam());
    // The point is twice the gap beside the center of the lamp's far edge. cos cos / (pi r^2) is
    // integrated over the lamp, in closed form along z and numerically along x.
    const double d = 2.0 * gap, h = 5.5 - static_cast<double>(corner.y);
    double form_factor = 0.0;
    constexpr int kSteps = 200000;
    const double log_ratio = std::log((1.0 + d) / d);
    for (int i = 0; i < kSteps; ++i) { // x = d exp(s): fine near the edge
      const double x = d * std::exp((i + 0.5) / kSteps * log_ratio), dx = x * log_ratio / kSteps;
      const double a2 = x * x + h * h, a = std::sqrt(a2);
      // Integral over z of h^2 / (pi (a^2 + z^2)^2) from -1/2 to 1/2.
      form_factor += dx * h * h / std::numbers::pi * (0.5 / (a2 * (a2 + 0.25)) + std::atan(0.5 / a) / (a2 * a));
    }
    const V3f target(6.0f + static_cast<float>(d), 5.5f, -2.5f);
    // A beam much narrower than the gap; positions of this size have a spacing of 5e-7.
    const Camera camera = beam_camera(target + V3f(1.0f, -1.0f, 0.3f), target, gap * 1e-2f);
    RenderSettings settings = small_render(V2i(8, 8), 1024);
    settings.integrator.max_bounces = 0;
    const Mean mean = render_mean(*world, camera, settings);
    const double expected = rho * emitted * form_factor;
    // Rounding moves the beam's center and the gap by one spacing of positions at most; the result
    // depends on both by up to their third power.
    EXPECT_NEAR(mean.luminance, expected, 4.5 * mean.standard_error + expected * 6.0 * 5e-7 / gap) << "gap " << gap;
  }
}

TEST_P(ClosedForm, PunctualLights) {
  const float rho = 0.8f;
  const Camera camera = beam_camera(V3f(1, 2, 1), V3f(0.0f), 1e-4f);
  RenderSettings settings = small_render(V2i(8, 8), 4);
  const auto lit_by = [&](PunctualLight light, const M44f& light_to_world) {
    Scene scene = make_scene({diffuse_material(Rgb(rho))}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0)});
    scene.lights.push_back(std::move(light));
    Node node;
    node.light = 0;
    node.matrix = light_to_world;
    scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(node);
    const auto world = make_world(std::move(scene), GetParam());
    return render_mean(*world, camera, settings).luminance;
  };
  const double brdf = rho / std::numbers::pi;
  // 5 candela at (0, 3, 4): distance 5, cosine 3/5.
  PunctualLight point;
  point.intensity = 5.0f;
  EXPECT_NEAR(lit_by(point, look_at(V3f(0, 3, 4), V3f(0.0f))), brdf * 5.0 / 25.0 * 0.6, 2e-4 * brdf);
  // 2 lux from 60 degrees.
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 2.0f;
  EXPECT_NEAR(lit_by(sun, look_at(V3f(0, 0.5f, std::sqrt(0.75f)), V3f(0.0f))), brdf * 2.0 * 0.5, 2e-4 * brdf);
  // A spot that looks at the point from above, and one that looks past it.
  PunctualLight spot;
  spot.kind = PunctualLight::Kind::spot;
  spot.intensity = 4.0f;
  spot.inner_cone_rad = 0.2f;
  spot.outer_cone_rad = 0.4f;
  EXPECT_NEAR(lit_by(spot, look_at(V3f(0, 2, 0), V3f(0.0f))), brdf * 4.0 / 4.0, 2e-4 * brdf);
  EXPECT_EQ(lit_by(spot, look_at(V3f(0, 2, 0), V3f(2, 0, 0))), 0.0);
}

// A convex white body in a uniform environment is invisible: shadow acne and light leaks would show
// at any scale.
TEST_P(ClosedForm, FurnaceAtEveryScale) {
  for (const float scale : {1e-3f, 1.0f, 1e5f})
    for (const V3f& center : {V3f(0.0f), V3f(30.0f, -20.0f, 10.0f)}) {
      const V3f c = center * scale;
      const auto world = make_world(make_scene({diffuse_material(Rgb(1.0f))}, {sphere(c, scale, 64, 0, false)}),
                                    GetParam(), std::make_shared<Environment>(Rgb(1.0f)));
      SceneCamera pinhole;
      pinhole.yfov_rad = 0.6f;
      const Camera camera(pinhole, look_at(c + V3f(1, 2, 3) * scale, c), V2i(32, 32));
      RenderSettings settings = small_render(V2i(32, 32), 16);
      SCOPED_TRACE(scale);
      expect_mean(render_mean(*world, camera, settings), 1.0);
    }
}

// BLEND passes 1 - alpha of camera rays and shadow rays.
TEST_P(ClosedForm, AlphaBlendIsCoverage) {
  Material veil = diffuse_material(Rgb(0.0f));
  veil.base_color_factor.w = 0.25f;
  veil.alpha_mode = AlphaMode::blend;
  const Camera camera = beam_camera(V3f(0, 3, 0.01f), V3f(0.0f), 0.1f, V2i(16, 16));
  RenderSettings settings = small_render(V2i(16, 16), 64);
  settings.integrator.max_bounces = 0;
  {
    const auto world = make_world(
        make_scene({emissive_material(Rgb(2.0f)), veil}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                                          quad(V3f(-5, 1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 1)}),
        GetParam());
    expect_mean(render_mean(*world, camera, settings), 2.0 * 0.75);
  }
  {
    // The veil is between plate and light but not between camera and plate.
    const float rho = 0.5f;
    const auto world = make_world(make_scene({diffuse_material(Rgb(rho)), emissive_material(Rgb(3.0f)), veil},
                                             {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                              quad(V3f(-1, 1, -0.5f), V3f(2, 0, 0), V3f(0, 0, 1), 1),
                                              quad(V3f(-2, 0.9f, -2), V3f(4, 0, 0), V3f(0, 0, 4), 2)}),
                                  GetParam());
    const Camera side = beam_camera(V3f(3, 0.5f, 0), V3f(0.0f), 1e-3f, V2i(16, 16));
    expect_mean(render_mean(*world, side, settings), rho * 3.0 * 4.0 * corner_form_factor(1.0, 0.5, 1.0) * 0.75);
  }
}

// MASK cuts at alpha >= cutoff.
TEST_P(ClosedForm, AlphaMask) {
  for (const bool cached : {false, true}) {
    Material leaf = diffuse_material(Rgb(0.0f));
    leaf.base_color_factor.w = cached ? 0.5f : 0.49f;
    leaf.alpha_mode = AlphaMode::mask;
    const auto world = make_world(
        make_scene({emissive_material(Rgb(2.0f)), leaf}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                                          quad(V3f(-5, 1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 1)}),
        GetParam());
    EXPECT_FLOAT_EQ(
        render_mean(*world, beam_camera(V3f(0, 3, 0.01f), V3f(0.0f), 0.1f), small_render(V2i(8, 8), 4)).rgb.x,
        cached ? 0.0f : 2.0f);
  }
}

// Single-sided emitters shine from their front only, double-sided ones from both.
TEST_P(ClosedForm, EmissionSides) {
  for (const bool double_sided : {false, true}) {
    Material lamp = emissive_material(Rgb(1.0f));
    lamp.double_sided = double_sided;
    const auto world =
        make_world(make_scene({lamp}, {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0)}), GetParam());
    const RenderSettings settings = small_render(V2i(8, 8), 4);
    EXPECT_FLOAT_EQ(render_mean(*world, beam_camera(V3f(0, 2, 0.01f), V3f(0.0f), 0.1f), settings).rgb.x, 1.0f);
    EXPECT_FLOAT_EQ(render_mean(*world, beam_camera(V3f(0, -2, 0.01f), V3f(0.0f), 0.1f), settings).rgb.x,
                    double_sided ? 1.0f : 0.0f);
  }
}

INSTANTIATE_TEST_SUITE_P(Accelerators, ClosedForm, testing::ValuesIn(kAllKinds), [](const auto& param) {
  return std::string(param.param == accel::Kind::brute_force ? "brute_force" : accel::kind_name(param.param));
});

// Light and BSDF sampling combined have the mean of BSDF sampling alone, on a glossy surface: the
// power heuristic must not change the mean.
TEST(MultipleImportanceSampling, AgreesWithBsdfSamplingAlone) {
  Material glossy;
  glossy.base_color_factor = V4f(0.9f, 0.9f, 0.9f, 1.0f);
  glossy.roughness_factor = 0.4f;
  Material lamp = emissive_material(Rgb(4.0f));
  Material unsampled = lamp; // BLEND emitters are found by BSDF sampling alone
  unsampled.alpha_mode = AlphaMode::blend;
  unsampled.base_color_factor.w = 0.9999999f;
  const auto mean_with = [&](const Material& light) {
    const auto world = make_world(make_scene({glossy, light}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                                               quad(V3f(-1, 1, -1.5f), V3f(2, 0, 0), V3f(0, 0, 1), 1)}),
                                  accel::Kind::embree);
    RenderSettings settings = small_render(V2i(16, 16), 1024);
    settings.integrator.max_bounces = 0;
    return render_mean(*world, beam_camera(V3f(0.3f, 0.7f, 2), V3f(0.0f), 0.5f, V2i(16, 16)), settings);
  };
  const Mean both = mean_with(lamp), bsdf_only = mean_with(unsampled);
  EXPECT_LT(both.standard_error, bsdf_only.standard_error);
  EXPECT_NEAR(both.luminance, bsdf_only.luminance, 4.5 * std::hypot(both.standard_error, bsdf_only.standard_error));
}

} // namespace
} // namespace kindling::test
