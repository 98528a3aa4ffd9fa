// Manifold sampling: known light through water, agreement with light paths, limits, obstacles.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/manifolds/manifolds.h"
#include "renderer/session/check_settings.h"
#include "tests/integrator/water_scenes.h"
#include "tests/session/same_bits.h"

#include <functional>
#include <numbers>

namespace kindling::test {
namespace {

constexpr float kRho = 0.6f, kIrradiance = 3.0f;

RenderSettings one_bounce(const V2i& size, uint32_t spp, int manifold_samples) {
  RenderSettings settings = small_render(size, spp);
  settings.integrator.max_bounces = settings.integrator.max_diffuse_bounces = 1;
  settings.integrator.max_glossy_bounces = 0;
  settings.integrator.manifold_samples = manifold_samples;
  return settings;
}

double fresnel(double cos_o, double eta) {
  const double cos_t = std::sqrt(1.0 - (1.0 - cos_o * cos_o) / (eta * eta));
  const double s = (cos_o - eta * cos_t) / (cos_o + eta * cos_t), p = (eta * cos_o - cos_t) / (eta * cos_o + cos_t);
  return 0.5 * (s * s + p * p);
}

// Suns without a size above a floor in water that absorbs light. Their light is refracted into the
// water and out of it; radiance falls by the square of the index on its way out.
TEST(Manifolds, LightTheFloorInWater) {
  constexpr double kEta = 1.33;
  for (const V3f& sun : {V3f(0, 5, 0), V3f(4, 3, 1)}) {
    Scene scene = floor_in_water(kRho, kIrradiance, 0.0f, sun);
    scene.materials[1].attenuation_distance_m = 2.0f;
    scene.materials[1].attenuation_color = Rgb(0.5f);
    const auto world = make_world(std::move(scene), accel::Kind::kdtree);
    const double cos_o = static_cast<double>(sun.normalized().y);
    const double cos_t = std::sqrt(1.0 - (1.0 - cos_o * cos_o) / (kEta * kEta));
    const double transmitted = (1.0 - fresnel(cos_o, kEta)) * (1.0 - fresnel(1.0, kEta));
    const double absorbed = std::pow(0.5, (1.0 / cos_t + 1.0) / 2.0); // one meter of depth
    const double expected =
        static_cast<double>(kRho * kIrradiance) / std::numbers::pi * cos_o * transmitted * absorbed / (kEta * kEta);
    const Camera camera = camera_above(V2i(16, 16));
    EXPECT_EQ(estimate_means(*world, camera, one_bounce(V2i(16, 16), 4, 0), 1).mean(), 0.0);
    for (const int samples : {1, 2, 8}) {
      const Estimate means = estimate_means(*world, camera, one_bounce(V2i(16, 16), 16, samples), 16);
      EXPECT_NEAR(means.mean(), expected, 4.5 * means.standard_error() + 1e-5 * expected) << samples;
      EXPECT_LT(means.standard_error(), 0.01 * expected);
    }
    RenderSettings together = one_bounce(V2i(16, 16), 16, 2); // with other ways to divide the work
    together.integrator.direct_samples = 4;
    together.sample_rates = SampleRateKind::noise;
    together.min_rates_gain = 0.0;
    const Estimate means = estimate_means(*world, camera, together, 16);
    EXPECT_NEAR(means.mean(), expected, 4.5 * means.standard_error() + 1e-5 * expected);
  }
}

// A smooth sphere of glass above a floor, or two of them as instances that are scaled and turned.
Scene spheres_of_glass(bool instances) {
  Scene scene = make_scene({diffuse_material(Rgb(0.7f)), glass_material(0.0f)},
                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0.0f), 1.0f, 64, 1)});
  M44f scaled, turned, moved;
  moved.setTranslation(V3f(0, 1.2f, 0));
  scene.nodes[1].matrix = moved;
  if (!instances) return scene;
  scaled.setScale(V3f(0.7f, 1.0f, 0.5f));
  turned.setAxisAngle(V3f(0.3f, 1.0f, 0.2f).normalized(), 0.7f);
  moved.setTranslation(V3f(0, 1.3f, 0));
  scene.nodes[1].matrix = scaled * turned * moved;
  Node second = scene.nodes[1];
  moved.setTranslation(V3f(-1.5f, 1.3f, 0.5f));
  second.matrix = scaled * turned * moved;
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(second);
  return scene;
}

// Light paths reach what the camera sees directly: the floor below the spheres.
void expect_agreement(Scene scene, const char* name) {
  const auto world = make_world(std::move(scene), accel::Kind::kdtree);
  const Camera camera = beam_camera(V3f(3.0f, 0.9f, 0.0f), V3f(0.8f, 0.0f, 0.0f), 0.5f, V2i(24, 24));
  RenderSettings settings = one_bounce(V2i(24, 24), 64, 0);
  settings.integrator.max_glossy_bounces = 0;
  settings.integrator.max_transmission_bounces = 1;
  const Estimate without = estimate_means(*world, camera, settings, 2);
  settings.integrator.light_paths = 1.0f;
  const Estimate expected = estimate_means(*world, camera, settings, 24);
  settings.integrator.light_paths = 0.0f;
  settings.samples_per_pixel = 16;
  settings.integrator.manifold_samples = 2;
  const Estimate found = estimate_means(*world, camera, settings, 16);
  const double error = std::hypot(expected.standard_error(), found.standard_error());
  EXPECT_NEAR(found.mean(), expected.mean(), 4.5 * error) << name;
  EXPECT_LT(error, 0.05 * (expected.mean() - without.mean())) << name;
}

TEST(Manifolds, AgreeWithLightPaths) {
  PunctualLight lamp;
  lamp.intensity = 20.0f;
  const M44f above = look_at(V3f(-1.0f, 6, 0.5f), V3f(0.0f));
  for (const bool instances : {false, true}) {
    Scene scene = spheres_of_glass(instances);
    place_light(scene, lamp, above);
    expect_agreement(std::move(scene), "lamp");
  }
  Scene spot = spheres_of_glass(false);
  PunctualLight cone = lamp;
  cone.kind = PunctualLight::Kind::spot;
  cone.inner_cone_rad = 0.05f;
  cone.outer_cone_rad = 0.2f;
  place_light(spot, cone, above);
  expect_agreement(std::move(spot), "spot");
  Scene two = spheres_of_glass(false);
  place_light(two, lamp, above);
  lamp.kind = PunctualLight::Kind::directional;
  lamp.intensity = 0.5f;
  place_light(two, lamp, look_at(V3f(-2, 5, 1), V3f(0.0f)));
  expect_agreement(std::move(two), "lamp and sun");
}

TEST(Manifolds, KeepBounceLimits) {
  expect_bounce_limits([](IntegratorSettings& settings) { settings.manifold_samples = 8; });
}

// What is in the way of the light: nothing, a wall above the water, one in it, a tinted thin wall.
TEST(Manifolds, MeetObstacles) {
  const auto light_below = [](const std::optional<Material>& material, float height) {
    Scene scene = floor_in_water(kRho, kIrradiance, 0.0f, V3f(3, 5, 0));
    if (material) add_object(scene, *material, quad(V3f(0.2f, height, 3), V3f(3, 0, 0), V3f(0, 0, -6), 0));
    const auto world = make_world(std::move(scene), accel::Kind::kdtree);
    RenderSettings settings = one_bounce(V2i(16, 16), 16, 8);
    SceneCamera camera;
    camera.kind = SceneCamera::Kind::orthographic;
    camera.xmag = camera.ymag = 0.05f;
    const Camera beside(camera, kindling::look_at(V3f(0, 5, 0), V3f(0.0f), V3f(0, 0, 1)), V2i(16, 16));
    return render_mean(*world, beside, settings);
  };
  const Mean free = light_below(std::nullopt, 0.0f);
  EXPECT_GT(free.luminance, 0.1);
  EXPECT_EQ(light_below(diffuse_material(Rgb(0.0f)), 1.5f).luminance, 0.0);
  EXPECT_EQ(light_below(diffuse_material(Rgb(0.0f)), 0.7f).luminance, 0.0);
  Material window = glass_material(0.0f);
  window.thickness_factor = 0.0f;
  window.base_color_factor = V4f(0.5f, 0.5f, 0.5f, 1.0f);
  const Mean tinted = light_below(window, 1.5f);
  const double cosine = 5.0 / std::sqrt(34.0);
  const double expected = 0.5 * (1.0 - fresnel(cosine, 1.5)) * free.luminance;
  EXPECT_NEAR(tinted.luminance, expected,
              4.5 * std::hypot(tinted.standard_error, expected / free.luminance * free.standard_error));
}

TEST(Manifolds, ConcernSmoothGlassAndLampsWithoutASize) {
  const auto concern = [](const Scene& scene) {
    IntegratorSettings settings;
    settings.manifold_samples = 1;
    return make_manifolds(settings, *make_world(scene, accel::Kind::kdtree)) != nullptr;
  };
  const Scene water = floor_in_water(kRho, kIrradiance, 0.0f, V3f(0, 5, 0));
  EXPECT_TRUE(concern(water));
  EXPECT_FALSE(concern(floor_in_water(kRho, kIrradiance, 1.0f, V3f(0, 5, 0)))); // a sun with a size
  Scene rough = water;
  rough.materials[1].roughness_factor = 0.3f;
  EXPECT_FALSE(concern(rough));
  Scene opaque = water;
  opaque.materials[1] = diffuse_material(Rgb(0.5f));
  EXPECT_FALSE(concern(opaque));
  EXPECT_EQ(make_manifolds({}, *make_world(water, accel::Kind::kdtree)), nullptr);
}

TEST(Manifolds, LeaveOtherImagesUnchanged) {
  const auto world = make_world(floor_in_water(kRho, kIrradiance, 2.0f, V3f(0, 5, 0)), accel::Kind::kdtree);
  const auto film = [&](int samples) {
    Result<RenderOutcome> outcome =
        render(*world, camera_above(V2i(16, 16)), one_bounce(V2i(16, 16), 8, samples), nullptr, nullptr);
    EXPECT_TRUE(outcome.ok());
    return std::move(outcome).value().film;
  };
  expect_same_bits(film(4), film(0), "manifold samples");
}

TEST(Manifolds, RefuseOtherTracersAndPasses) {
  const auto refusal = [](const std::function<void(RenderSettings&)>& change) {
    RenderSettings settings = one_bounce(V2i(16, 16), 4, 2);
    change(settings);
    const Result<void> checked = check_settings(settings, camera_above(V2i(16, 16)));
    return checked.ok() ? std::string() : checked.error().message;
  };
  EXPECT_EQ(refusal([](auto&) {}), "");
  EXPECT_EQ(refusal([](auto& s) { s.integrator.direct_samples = 4; }), "");
  EXPECT_EQ(refusal([](auto& s) { s.sample_rates = SampleRateKind::noise; }), "");
  EXPECT_EQ(refusal([](auto& s) { s.device = DeviceKind::host; }), "");
  const auto expect_refused = [&](const char* words, const std::function<void(RenderSettings&)>& change) {
    EXPECT_NE(refusal(change).find(words), std::string::npos) << words << ": " << refusal(change);
  };
  expect_refused("with --integrator whitted; use path", [](auto& s) { s.integrator.kind = IntegratorKind::whitted; });
  expect_refused("with --light-paths", [](auto& s) { s.integrator.light_paths = 0.5f; });
  expect_refused("with --photons", [](auto& s) { s.integrator.photons = 0.5f; });
  expect_refused("with --caustics off", [](auto& s) { s.integrator.caustics = Caustics::off; });
  expect_refused("with light groups or light passes", [](auto& s) { s.integrator.light_groups = LightGrouping::kind; });
  expect_refused("with light groups or light passes", [](auto& s) { s.aovs.insert(Aov::diffuse_direct); });
  expect_refused("with light groups or light passes", [](auto& s) { s.aovs.insert(Aov::glossy_color); });
  expect_refused("manifold samples 17: 0 to 16", [](auto& s) { s.integrator.manifold_samples = 17; });
  expect_refused("manifold samples -1", [](auto& s) { s.integrator.manifold_samples = -1; });
}

} // namespace
} // namespace kindling::test
