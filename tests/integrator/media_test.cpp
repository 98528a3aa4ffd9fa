// The path tracer with every accelerator on glass, media and thin walls with closed-form solutions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/dispersion.h"
#include "tests/integrator/slabs_of_media.h"
#include "tests/integrator/test_scenes.h"
#include "tests/sampling/random.h"

#include <numbers>

namespace kindling::test {
namespace {

// Two-sided level of 5e-6 for each comparison, and room for float rounding.
void expect_near_mean(double value, double expected, double standard_error, const char* what) {
  EXPECT_NEAR(value, expected, 4.5 * standard_error + 1e-4 * expected) << what << ", standard error " << standard_error;
}

// Transmissive glass without a thickness.
Material thin_wall(const Rgb& color, float specular = 1.0f) {
  Material material = glass(1.5f);
  material.thickness_factor = 0.0f;
  material.base_color_factor = V4f(color.x, color.y, color.z, 1.0f);
  material.specular_factor = specular;
  return material;
}

std::vector<Primitive> joined(std::vector<std::vector<Primitive>> parts) {
  std::vector<Primitive> all;
  for (std::vector<Primitive>& part : parts)
    for (Primitive& primitive : part) all.push_back(std::move(primitive));
  return all;
}

// Looks along -z from z = 10 at a wall of `radiance` at z = -10.
Mean seen_through(std::vector<Material> materials, std::vector<Primitive> primitives, const Rgb& radiance,
                  accel::Kind kind, uint32_t spp = 64, bool from_behind = false) {
  const float side = from_behind ? -1.0f : 1.0f;
  primitives.push_back(
      quad(V3f(-50, -50, -10 * side), V3f(100, 0, 0), V3f(0, 100, 0), static_cast<int>(materials.size())));
  materials.push_back(emissive_material(radiance));
  const auto world = make_world(make_scene(std::move(materials), std::move(primitives)), kind);
  return render_mean(*world, beam_camera(V3f(0.1f, 0.2f, 9 * side), V3f(0.1f, 0.2f, 0), 1e-3f),
                     small_render(V2i(8, 8), spp));
}

class Media : public testing::TestWithParam<accel::Kind> {};
INSTANTIATE_TEST_SUITE_P(Accelerators, Media, testing::ValuesIn(kAllKinds), [](const auto& param) {
  return std::string(param.param == accel::Kind::brute_force ? "brute_force" : accel::kind_name(param.param));
});

// KHR_materials_volume: after the attenuation distance white light has the attenuation color. Two
// interfaces with all reflections between them give T = (1 - F)^2 a / (1 - F^2 a^2).
TEST_P(Media, SlabFollowsBeerAndLambert) {
  const Rgb color(0.5f, 0.25f, 0.9f);
  for (const float ior : {1.0f, 1.5f, 2.4f}) {
    const Mean mean = seen_through({absorbing(ior, color, 0.5f)}, slab(-1.5f, 0.0f, 0), Rgb(2.0f), GetParam(), 1024);
    const double f = std::pow((ior - 1.0) / (ior + 1.0), 2);
    double expected = 0.0;
    for (unsigned c = 0; c < 3; ++c) {
      const double a = std::pow(color[c], 3.0);
      expected += (c == 0 ? 0.2126 : c == 1 ? 0.7152 : 0.0722) * 2.0 * (1 - f) * (1 - f) * a / (1 - f * f * a * a);
    }
    expect_near_mean(mean.luminance, expected, mean.standard_error, "slab");
  }
}

// The extension has a single factor 1 - F for both faces of a thin wall. Two thin walls with all
// reflections between them give T^2 / (1 - F^2).
TEST_P(Media, ThinWallsTransmit) {
  const double f = 0.04, t = 1.0 - f;
  const std::vector<Primitive> one = {quad(V3f(-4, -4, 0), V3f(8, 0, 0), V3f(0, 8, 0), 0)};
  const Mean single = seen_through({thin_wall(Rgb(1.0f))}, one, Rgb(1.0f), GetParam(), 1024);
  expect_near_mean(single.luminance, t, single.standard_error, "one thin_wall");
  std::vector<Primitive> two = one;
  two.push_back(quad(V3f(-4, -4, -1), V3f(8, 0, 0), V3f(0, 8, 0), 0));
  const Mean both = seen_through({thin_wall(Rgb(1.0f))}, two, Rgb(1.0f), GetParam(), 4096);
  expect_near_mean(both.luminance, t * t / (1.0 - f * f), both.standard_error, "two thin_walls");
}

// Light and BSDF sampling through a thin wall estimate the same light: the form factor of a
// rectangle, tinted.
TEST_P(Media, ThinWallsTintTheLightOfAnAreaLight) {
  const Rgb tint(0.9f, 0.5f, 0.1f);
  const auto scene = [&](bool with_thin_wall) {
    std::vector<Primitive> primitives = {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 1),
                                         quad(V3f(-1, 1, -0.5f), V3f(2, 0, 0), V3f(0, 0, 1), 2)};
    if (with_thin_wall) primitives.push_back(quad(V3f(-6, 0.5f, -6), V3f(12, 0, 0), V3f(0, 0, 12), 0));
    return make_scene({thin_wall(tint, 0.0f), diffuse_material(Rgb(0.5f)), emissive_material(Rgb(3.0f))}, primitives);
  };
  const Camera camera = beam_camera(V3f(3, 0.4f, 0), V3f(0.0f), 1e-3f);
  RenderSettings settings = small_render(V2i(8, 8), 1024);
  settings.integrator.max_bounces = 0;
  const auto clear = make_world(scene(false), GetParam());
  const auto tinted = make_world(scene(true), GetParam());
  const Mean without = render_mean(*clear, camera, settings);
  const Mean with = render_mean(*tinted, camera, settings);
  for (unsigned c = 0; c < 3; ++c)
    EXPECT_NEAR(with.rgb[c], without.rgb[c] * tint[c], 4.5 * (with.standard_error + without.standard_error)) << c;
}

// The background behind a thin wall is tinted; a transparent one gives the wall's coverage as
// alpha.
TEST_P(Media, BackgroundIsSeenThroughThinWalls) {
  const Rgb tint(0.9f, 0.6f, 0.3f);
  const auto world = make_world(
      make_scene({thin_wall(tint, 0.0f)}, {quad(V3f(-4, -4, 0), V3f(8, 0, 0), V3f(0, 8, 0), 0)}), GetParam());
  const Camera camera = beam_camera(V3f(0, 0, 3), V3f(0.0f), 1e-3f);
  RenderSettings settings = small_render(V2i(8, 8), 64);
  settings.integrator.background = Rgb(0.5f, 0.5f, 1.0f);
  const Mean mean = render_mean(*world, camera, settings);
  for (unsigned c = 0; c < 3; ++c) EXPECT_NEAR(mean.rgb[c], tint[c] * (c == 2 ? 1.0f : 0.5f), 1e-4f) << c;
  settings.integrator.background.reset();
  settings.integrator.transparent_background = true;
  const Result<RenderOutcome> outcome = render(*world, camera, settings, nullptr, nullptr);
  double alpha = 0.0;
  for (const float a : outcome.value().film.resolve(Aov::alpha)) alpha += a / 64.0;
  EXPECT_NEAR(alpha, 0.4, 1e-4);
}

// A sun behind two thin walls that face it. Only shadow rays can find it.
TEST_P(Media, SunShinesThroughThinWalls) {
  Scene scene = make_scene({thin_wall(Rgb(0.8f)), diffuse_material(Rgb(0.5f))},
                           {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 1),
                            quad(V3f(-6, 2, 6), V3f(12, 0, 0), V3f(0, 0, -12), 0),
                            quad(V3f(-6, 3, 6), V3f(12, 0, 0), V3f(0, 0, -12), 0)});
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 2.0f;
  scene.lights.push_back(sun);
  Node node;
  node.light = 0;
  node.matrix = look_at(V3f(0.0f, 5.0f, 0.01f), V3f(0.0f));
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  const auto world = make_world(std::move(scene), GetParam());
  RenderSettings settings = small_render(V2i(8, 8), 16);
  settings.integrator.max_bounces = 0;
  const Mean mean = render_mean(*world, beam_camera(V3f(3, 1, 0), V3f(0.0f), 1e-3f), settings);
  const double t = 0.8 * 0.96;
  EXPECT_NEAR(mean.luminance, 0.5 / std::numbers::pi * 2.0 * t * t, 1e-4);
}

// Right-angled prism: light enters one leg, is totally reflected at the hypotenuse, and leaves
// through the other leg towards the wall. The exit reflects F back the same way, which gives
// (1 - F)^2 / (1 - F^2).
TEST_P(Media, TotalInternalReflectionLosesNothing) {
  Primitive prism;
  prism.material = 0;
  // Legs at z = 1 (facing +z) and x = 1 (facing +x); the right angle is at (1, ., 1), the
  // hypotenuse from (-1, 1) to (1, -1).
  const V3f p[6] = {{-1, -1, 1}, {1, -1, 1}, {1, -1, -1}, {-1, 1, 1}, {1, 1, 1}, {1, 1, -1}};
  prism.positions.assign(p, p + 6);
  prism.indices = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5, 0, 2, 1, 3, 4, 5};
  const auto world = make_world(make_scene({glass(1.5f), emissive_material(Rgb(1.0f))},
                                           {prism, quad(V3f(5, -9, 9), V3f(0, 0, -18), V3f(0, 18, 0), 1)}),
                                GetParam());
  const Mean mean =
      render_mean(*world, beam_camera(V3f(0.1f, 0.2f, 4), V3f(0.1f, 0.2f, 0), 1e-3f), small_render(V2i(8, 8), 1024));
  const double f = 0.04;
  expect_near_mean(mean.luminance, (1 - f) * (1 - f) / (1 - f * f), mean.standard_error, "prism");
}

// A prism of 30 degrees, entered at right angles: the exit deflects a wavelength by
// asin(n sin 30) - 30 degrees. A window behind it passes the wavelengths between two angles; its
// color is the mean of their weights.
TEST_P(Media, PrismDispersesByItsAbbeNumber) {
  Material flint = glass(1.6f);
  flint.dispersion = 20.0f / 30.0f; // Abbe number 30
  // Entrance at z = 0 facing +z; thin at x = 1 and thick at x = -1, so the exit's outward normal is
  // (sin 30, 0, -cos 30).
  const float t = std::tan(kPi / 6.0f);
  const float thin = -0.01f, thick = thin - 2.0f * t;
  Primitive prism;
  prism.material = 0;
  prism.positions = {{-1, -1, 0}, {1, -1, 0},   {1, -1, thin},   {-1, 1, 0},
                     {1, 1, 0},   {1, 1, thin}, {-1, -1, thick}, {-1, 1, thick}};
  prism.indices = {
      0, 1, 4, 0, 4, 3, /* exit */ 6, 7, 2, 2, 7, 5, /* sides */ 1, 2, 5, 1, 5, 4, 0, 3, 7, 0, 7, 6, 0, 6, 2, 0, 2, 1,
      3, 4, 5, 3, 5, 7};
  // Light is bent towards the thick end, -x.
  const auto bend = [&](double nm) {
    return std::asin(double{dispersed_ior(1.6f, flint.dispersion, static_cast<float>(nm))} * 0.5) -
           std::numbers::pi / 6.0;
  };
  const double low = bend(587.6), high = bend(500.0); // more for shorter waves
  const float distance = 1000.0f;                     // the beam is 1 mm, the window centimeters
  const V3f exit_point(0.0f, 0.0f, thin - t);
  const auto on_screen = [&](double angle) {
    return static_cast<float>(-std::tan(angle) * static_cast<double>(distance));
  };
  Primitive window = quad(V3f(on_screen(high), -50, exit_point.z - distance),
                          V3f(on_screen(low) - on_screen(high), 0, 0), V3f(0, 100, 0), 1);
  const auto world = make_world(make_scene({flint, emissive_material(Rgb(1.0f))}, {prism, window}), GetParam());
  RenderSettings settings = small_render(V2i(8, 8), 2048);
  const Mean mean = render_mean(*world, beam_camera(V3f(0, 0, 3), V3f(0.0f), 1e-3f), settings);

  double expected[3] = {};
  constexpr int kSteps = 100000;
  for (int i = 0; i < kSteps; ++i) {
    const WavelengthSample wave = sample_wavelength((static_cast<float>(i) + 0.5f) / kSteps);
    if (wave.nm < 500.0f || wave.nm > 587.6f) continue;
    // Fresnel at both faces, unpolarized; what is reflected inside leaves elsewhere.
    const double n = dispersed_ior(1.6f, flint.dispersion, wave.nm), f0 = std::pow((n - 1) / (n + 1), 2);
    const double ci = std::cos(std::numbers::pi / 6), co = std::sqrt(1 - n * n * 0.25);
    const double rs = (n * ci - co) / (n * ci + co), rp = (n * co - ci) / (n * co + ci);
    for (unsigned k = 0; k < 3; ++k)
      expected[k] += double{wave.weight[k]} * (1 - f0) * (1 - 0.5 * (rs * rs + rp * rp)) / kSteps;
  }
  for (unsigned k = 0; k < 3; ++k)
    EXPECT_NEAR(mean.rgb[k], expected[k], 4.5 * mean.standard_error * (k == 1 ? 2.0 : 4.0) + 2e-3) << k;
  EXPECT_GT(mean.rgb.y, 1.5f * mean.rgb.x); // green
}

// The spectrum adds up to white: dispersion redirects light without a color of its own.
TEST_P(Media, DispersiveGlassInAWhiteFurnaceIsWhite) {
  Material flint = glass(1.7f);
  flint.dispersion = 1.0f;
  const auto world = make_world(make_scene({flint}, {sphere(V3f(0.0f), 1.0f, 24, 0)}), GetParam(),
                                std::make_shared<Environment>(Rgb(1.0f)));
  SceneCamera pinhole;
  const Camera camera(pinhole, look_at(V3f(0, 0, 2.5f), V3f(0.0f)), V2i(16, 16));
  RenderSettings settings = small_render(V2i(16, 16), 256);
  settings.integrator.max_transmission_bounces = settings.integrator.max_glossy_bounces = 200;
  settings.integrator.max_bounces = 200;
  const Mean mean = render_mean(*world, camera, settings);
  for (unsigned c = 0; c < 3; ++c) EXPECT_NEAR(mean.rgb[c], 1.0f, 4.5 * 4.0 * mean.standard_error + 1e-3) << c;
}

// Two media overlap between z = 0 and z = 0.2. The one entered last is effective there, from both
// sides.
TEST_P(Media, InnermostMediumIsEffectiveInOverlaps) {
  const std::vector<Material> materials = {absorbing(1.0f, Rgb(0.5f), 1.0f), absorbing(1.0f, Rgb(0.2f), 1.0f)};
  const auto primitives = [] { return joined({slab(0.0f, 1.0f, 0), slab(-1.0f, 0.2f, 1)}); };
  const Mean front = seen_through(materials, primitives(), Rgb(1.0f), GetParam());
  EXPECT_NEAR(front.luminance, std::pow(0.5, 0.8) * std::pow(0.2, 1.2), 1e-4);
  const Mean back = seen_through(materials, primitives(), Rgb(1.0f), GetParam(), 64, true);
  EXPECT_NEAR(back.luminance, std::pow(0.2, 1.0) * std::pow(0.5, 1.0), 1e-4);
}

// A slab of water inside a slab of glass has four interfaces.
TEST_P(Media, NestedIndicesAreRelative) {
  const Mean mean = seen_through({glass(1.5f), glass(1.33f)}, joined({slab(-3.0f, 0.0f, 0), slab(-2.0f, -1.0f, 1)}),
                                 Rgb(1.0f), GetParam(), 4096);
  // Symmetric layers without interference combine to T = T1 T2 / (1 - R1 R2) and
  // R = R1 + T1^2 R2 / (1 - R1 R2).
  const auto twice = [](double r) { return 2 * r / (1 + r); }; // a slab of one interface reflectance r
  const double outer = 0.04, inner = twice(std::pow((1.5 - 1.33) / (1.5 + 1.33), 2));
  const double t1 = 1 - outer, t2 = 1 - inner;
  const double t12 = t1 * t2 / (1 - outer * inner), r21 = inner + t2 * t2 * outer / (1 - outer * inner);
  expect_near_mean(mean.luminance, t12 * t1 / (1 - r21 * outer), mean.standard_error, "glass around water");
}

// Scattering without absorption conserves energy.
TEST_P(Media, ScatteringMediumInAWhiteFurnaceIsWhite) {
  for (const float g : {0.0f, 0.7f}) {
    Material cloud = absorbing(1.0f, Rgb(0.1f, 0.3f, 0.5f), 0.7f);
    cloud.multiscatter_color = Rgb(1.0f);
    cloud.scatter_anisotropy = g;
    const auto world = make_world(make_scene({cloud}, {sphere(V3f(0.0f), 1.0f, 24, 0, false)}), GetParam(),
                                  std::make_shared<Environment>(Rgb(1.0f)));
    const Mean mean =
        render_mean(*world, beam_camera(V3f(0, 0, 3), V3f(0.1f, 0.05f, 0), 1e-2f), small_render(V2i(8, 8), 1024));
    for (unsigned c = 0; c < 3; ++c)
      EXPECT_NEAR(mean.rgb[c], 1.0f, 4.5 * 4.0 * mean.standard_error + 1e-3) << g << " " << c;
  }
}

// Chandrasekhar's half space with isotropic scattering: seen along mu under a white sky its albedo
// is 1 - sqrt(1 - a) H(mu).
TEST_P(Media, DeepMediumHasTheAlbedoOfAHalfSpace) {
  Material wax = absorbing(1.0f, Rgb(1e-3f), 0.01f); // an optical depth of 690 per meter
  wax.multiscatter_color = Rgb(0.6f);
  const auto world =
      make_world(make_scene({wax}, slab(-1.0f, 0.0f, 0)), GetParam(), std::make_shared<Environment>(Rgb(1.0f)));
  const Mean mean =
      render_mean(*world, beam_camera(V3f(0.1f, 0.2f, 3), V3f(0.1f, 0.2f, 0), 1e-3f), small_render(V2i(8, 8), 1024));
  const Medium medium = make_medium(wax);
  const double a = medium.scattering.x / medium.extinction.x;
  // 1 / H(mu) = sqrt(1 - a) + a / 2 integral of m H(m) / (mu + m), by iteration.
  constexpr int kNodes = 400;
  std::vector<double> h(kNodes + 1, 1.0); // the last at mu = 1
  const auto node = [](int i) { return i == kNodes ? 1.0 : (i + 0.5) / kNodes; };
  for (int round = 0; round < 200; ++round) {
    std::vector<double> next(h.size());
    for (int i = 0; i <= kNodes; ++i) {
      double sum = 0.0;
      for (int j = 0; j < kNodes; ++j) sum += node(j) * h[static_cast<size_t>(j)] / (node(i) + node(j)) / kNodes;
      next[static_cast<size_t>(i)] = 1.0 / (std::sqrt(1.0 - a) + 0.5 * a * sum);
    }
    h = next;
  }
  const double expected = 1.0 - std::sqrt(1.0 - a) * h[kNodes];
  expect_near_mean(mean.luminance, expected, mean.standard_error, "half space");
  // The multiscatter color is the albedo averaged over all directions; the fit has an error of 1 %.
  double mean_h = 0.0;
  for (int j = 0; j < kNodes; ++j) mean_h += 2.0 * node(j) * h[static_cast<size_t>(j)] / kNodes;
  EXPECT_NEAR(1.0 - std::sqrt(1.0 - a) * mean_h, 0.6, 0.01);
}

// Reflectance of a dielectric boundary for unpolarized light; `eta`: index beyond over index here.
double fresnel(double cosine, double eta) {
  const double sine2 = (1.0 - cosine * cosine) / (eta * eta);
  if (sine2 >= 1.0) return 1.0;
  const double beyond = std::sqrt(1.0 - sine2);
  const double s = (cosine - eta * beyond) / (cosine + eta * beyond);
  const double p = (beyond - eta * cosine) / (beyond + eta * cosine);
  return 0.5 * (s * s + p * p);
}

// A slab of refracting, scattering wax under a white sky, seen from above, against a random walk
// along its depth. Half of the light inside is reflected at a boundary before it is scattered
// again, so each step needs a distance of its own.
TEST_P(Media, ReflectionsBetweenScatteringAreIndependent) {
  constexpr double kIor = 1.5;
  Material wax = absorbing(static_cast<float>(kIor), Rgb(0.4f), 1.0f);
  wax.multiscatter_color = Rgb(0.7f);
  std::vector<Primitive> wide = slab(-1.0f, 0.0f, 0);
  for (Primitive& face : wide)
    for (V3f& position : face.positions) position *= V3f(100.0f, 100.0f, 1.0f);
  const auto world =
      make_world(make_scene({wax}, std::move(wide)), GetParam(), std::make_shared<Environment>(Rgb(1.0f)));
  RenderSettings settings = small_render(V2i(8, 8), 1024);
  settings.integrator.max_bounces = settings.integrator.max_glossy_bounces = 200;
  const Mean mean = render_mean(*world, beam_camera(V3f(0.1f, 0.2f, 3), V3f(0.1f, 0.2f, 0), 1e-3f), settings);
  const Medium medium = make_medium(wax);
  const double albedo = medium.scattering.x / medium.extinction.x, extinction = medium.extinction.x;
  constexpr int kWalks = 200000;
  Random random(1);
  double sum = 0.0, sum2 = 0.0;
  for (int i = 0; i < kWalks; ++i) {
    double weight = 1.0, depth = 0.0, down = 1.0; // cosine of the direction with that of depth
    bool outside = random.next_double() < fresnel(1.0, kIor);
    while (!outside) {
      depth -= down * std::log(1.0 - random.next_double()) / extinction;
      if (depth > 0.0 && depth < 1.0) {
        weight *= albedo;
        down = 1.0 - 2.0 * random.next_double();
      } else {
        outside = random.next_double() >= fresnel(std::abs(down), 1.0 / kIor);
        depth = depth <= 0.0 ? 0.0 : 1.0;
        down = -down;
      }
    }
    sum += weight;
    sum2 += weight * weight;
  }
  const double expected = sum / kWalks, variance = sum2 / kWalks - expected * expected;
  expect_near_mean(mean.luminance, expected, std::hypot(mean.standard_error, std::sqrt(variance / kWalks)),
                   "refracting slab");
}

} // namespace
} // namespace kindling::test
