// Photons with motion blur: moving surfaces, lights and cameras, each at the time of the path.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/light_path_view.h"
#include "tests/integrator/motion_scenes.h"
#include "tests/integrator/water_scenes.h"

#include <cmath>
#include <numbers>

namespace kindling::test {
namespace {

std::unique_ptr<const World> moving(Scene scene) {
  return make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, accel::Kind::kdtree);
}

Camera open_camera(const V2i& size_px) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 0.5f;
  return {camera, kindling::look_at(V3f(0, 5, 0), V3f(0.0f), V3f(0, 0, 1)), size_px,
          CameraMotion{.shutter_open = true}};
}

// The density of times integrates to 1 over the times of paths, and over those of photons.
TEST(MovingPhotons, TimesHaveADensity) {
  constexpr int kSteps = 20000;
  for (const float span : {0.125f, 0.03f, 0.5f})
    for (const float one : {0.0f, 0.01f, 0.1f, 0.4f, 0.9f, 0.99f, 1.0f}) {
      double over_paths = 0.0, over_photons = 0.0;
      for (int i = 0; i < kSteps; ++i) {
        const float other = (static_cast<float>(i) + 0.5f) / kSteps;
        over_paths += static_cast<double>(LightPathView::photon_time_density(other, one, span)) / kSteps;
        over_photons += static_cast<double>(LightPathView::photon_time_density(one, other, span)) / kSteps;
      }
      // Each of three ends of intervals is met within half a step.
      const double step = 3.0 * 0.5 / kSteps / (2.0 * static_cast<double>(span));
      EXPECT_NEAR(over_paths, 1.0, step + 1e-6) << span << " " << one;
      EXPECT_NEAR(over_photons, 1.0, step + 1e-6) << span << " " << one;
    }
  LightPathView view;
  view.samples_per_map = 4;
  EXPECT_EQ(view.photon_time_span(3), view.photon_time_span(0));
  EXPECT_NEAR(view.photon_time_span(4000) / view.photon_time_span(0), std::pow(4001.0, -1.0 / 6.0), 1e-6);
}

// A floor that rises through all of the water, turns and grows is as bright as one at rest, whose
// light is known. At its speed photons of other times are far off its plane.
TEST(MovingPhotons, FloorThatRisesAndGrows) {
  const float rho = 0.6f, irradiance = 3.0f;
  Scene scene = floor_in_water(rho, irradiance, 0.0f, V3f(0, 5, 0));
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {0, -0.4f, 0, 0, 0.9f, 0});
  animate(scene, 0, AnimatedProperty::scale, {0, 1}, {0.5f, 1, 0.5f, 1, 1, 0.8f});
  animate_turn(scene, 0, V3f(0, 1, 0), 60.0f);
  const auto world = moving(std::move(scene));
  ASSERT_TRUE(world->has_motion);
  RenderSettings settings = small_render(V2i(16, 16), 16);
  settings.integrator.max_bounces = settings.integrator.max_diffuse_bounces = 1;
  settings.integrator.max_glossy_bounces = 0;
  settings.integrator.photons = 1.0f;
  const double fresnel = std::pow(0.33 / 2.33, 2.0);
  const double expected =
      static_cast<double>(rho * irradiance) / std::numbers::pi * std::pow((1.0 - fresnel) / 1.33, 2.0);
  const Estimate means = estimate_means(*world, open_camera(settings.size_px), settings, 32);
  EXPECT_NEAR(means.mean(), expected, 4.5 * means.standard_error());
  EXPECT_LT(means.standard_error(), 0.01 * expected);
}

// A floor in water, white on one side and black on the other, below a lamp without a size, which
// photons alone find.
constexpr float kLampHeight = 12.0f; // outside of the sphere at which its light is aimed
Scene floor_below_lamp(float lamp_x) {
  Scene scene = floor_in_water(0.6f, 0.0f, 0.0f, V3f(0, 5, 0));
  add_object(scene, diffuse_material(Rgb(0.0f)), quad(V3f(0, 0.01f, 3), V3f(3, 0, 0), V3f(0, 0, -6), 0));
  PunctualLight lamp;
  lamp.intensity = 100.0f;
  place_light(scene, lamp, M44f());
  scene.nodes.back().matrix.reset();
  scene.nodes.back().local.translation = V3f(lamp_x, kLampHeight, 0);
  return scene;
}

// While the lamp moves away, the camera moves from the white side to the black one: it sees the
// light of the first half of the time, as stills do whose mean is taken. Light of all times would
// be a fifth less. In the unit of time the light curves by 2.8 times itself at most; spans of the
// mean square .0042 blur that by a sixth of the product: by .2 %.
TEST(MovingPhotons, TimesOfLightAndViewBelongTogether) {
  constexpr float kLampPath = 10.0f;
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 0.5f;
  const auto above = [](float time) {
    const float x = 3.0f * time - 1.5f;
    return kindling::look_at(V3f(x, 5, 0), V3f(x, 0, 0), V3f(0, 0, 1));
  };
  RenderSettings settings = small_render(V2i(16, 16), 256);
  settings.guiding = Guiding::off;
  settings.integrator.photons = 1.0f;
  settings.integrator.max_bounces = settings.integrator.max_diffuse_bounces = 1;
  settings.integrator.max_glossy_bounces = 0;
  constexpr int kStills = 30; // the white part of the view begins and ceases to shrink between two
  Estimate stills;
  for (uint32_t seed = 0; seed < 16; ++seed) {
    double sum = 0.0;
    for (int i = 0; i < kStills; ++i) {
      const float time = (static_cast<float>(i) + 0.5f) / kStills;
      const auto still = make_world(floor_below_lamp(kLampPath * time), accel::Kind::kdtree);
      RenderSettings few = settings;
      few.samples_per_pixel = 16;
      few.seed = 1000 + seed * kStills + static_cast<uint32_t>(i);
      sum += render_mean(*still, {camera, above(time), settings.size_px}, few).luminance;
    }
    stills.add(sum / kStills);
  }
  Scene scene = floor_below_lamp(0.0f);
  const auto lamp = static_cast<int>(scene.nodes.size()) - 1;
  animate(scene, lamp, AnimatedProperty::translation, {0, 1}, {0, kLampHeight, 0, kLampPath, kLampHeight, 0});
  const auto world = moving(std::move(scene));
  ASSERT_TRUE(world->has_motion);
  const std::vector<M44f> later{above(1.0f)};
  const Estimate means =
      estimate_means(*world, {camera, above(0.0f), settings.size_px, CameraMotion{later, true}}, settings, 16);
  const double error = std::hypot(means.standard_error(), stills.standard_error());
  EXPECT_NEAR(means.mean(), stills.mean(), 4.5 * error + 0.002 * stills.mean());
  EXPECT_LT(error, 0.02 * stills.mean());
}

// Casters and receivers of all kinds of motion, where the camera sees them directly, too.
TEST(MovingPhotons, AgreeWithPathsFromTheCamera) {
  Scene scene = floor_in_water(0.6f, 3.0f, 20.0f, V3f(1, 5, 0.5f));
  const auto metal = static_cast<int>(scene.nodes.size());
  add_object(scene, metal_material(Rgb(0.9f), 0.0f), sphere(V3f(0.3f, 1.4f, 0.2f), 0.3f, 48, 0));
  add_object(scene, glass_material(0.1f), sphere(V3f(-0.2f, 1.25f, -0.3f), 0.2f, 48, 0));
  animate(scene, metal, AnimatedProperty::translation, {0, 1}, {-0.3f, 0, 0, 0.3f, 0.2f, 0});
  add_morph(scene, metal + 1, [](const V3f& p) { return V3f(0.3f * p.x, 0.2f, 0); });
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {0, -0.3f, 0, 0.2f, 0.3f, 0});
  const auto world = moving(std::move(scene));
  RenderSettings settings = small_render(V2i(24, 24), 256);
  const Camera camera = open_camera(settings.size_px);
  const Estimate without = estimate_means(*world, camera, settings, 16);
  settings.integrator.photons = 1.0f;
  const Estimate with = estimate_means(*world, camera, settings, 16);
  const double error = std::hypot(without.standard_error(), with.standard_error());
  EXPECT_NEAR(with.mean(), without.mean(), 4.5 * error + 0.002 * without.mean());
  EXPECT_LT(error, 0.007 * without.mean());
}

} // namespace
} // namespace kindling::test
