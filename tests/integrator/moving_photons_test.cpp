// Photons with motion blur: moving surfaces, lights and cameras, each at the time of the path.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/stages/light_path_view.h"
#include "tests/integrator/motion_scenes.h"
#include "tests/integrator/water_scenes.h"

#include <cmath>
#include <functional>
#include <numbers>

namespace kindling::test {
namespace {

std::unique_ptr<const World> moving(Scene scene) {
  return make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, accel::Kind::kdtree);
}

Camera open_camera(const V2i& size_px, const std::vector<M44f>& later = {}) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 0.5f;
  return {camera, kindling::look_at(V3f(0, 5, 0), V3f(0.0f), V3f(0, 0, 1)), size_px, CameraMotion{later, true}};
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

// Expects the mean that paths from the camera find. `bias`: relative.
void expect_mean_of_camera_paths(const World& world, const Camera& camera, uint32_t samples, double bias) {
  RenderSettings settings = small_render(camera.size_px(), samples);
  const Estimate without = estimate_means(world, camera, settings, 16);
  settings.integrator.photons = 1.0f;
  const Estimate with = estimate_means(world, camera, settings, 16);
  const double error = std::hypot(without.standard_error(), with.standard_error());
  EXPECT_NEAR(with.mean(), without.mean(), 4.5 * error + bias * without.mean());
  EXPECT_LT(error, 0.007 * without.mean());
}

// While the sun goes down by 60 degrees, the camera moves from a white half of the floor to a black
// one: it sees the light of the first half of the time. Light of all times would be a seventh less.
// The sine of the sun's height curves by 1.1 in the unit of time; a span of an eighth, which is the
// first one, blurs that by a sixth of its square: by .3 %.
TEST(MovingPhotons, TimesOfLightAndViewBelongTogether) {
  Scene scene = floor_in_water(0.6f, 3.0f, 40.0f, V3f(0, 5, 0));
  add_object(scene, diffuse_material(Rgb(0.0f)), quad(V3f(0, 0.01f, 3), V3f(3, 0, 0), V3f(0, 0, -6), 0));
  constexpr int kSun = 2;
  Node turning;
  turning.children = {kSun};
  std::erase(scene.scenes[0].nodes, kSun);
  const auto pivot = static_cast<int>(scene.nodes.size());
  scene.scenes[0].nodes.push_back(pivot);
  scene.nodes.push_back(turning);
  animate_turn(scene, pivot, V3f(0, 0, 1), 60.0f);
  const auto world = moving(std::move(scene));
  const auto above = [](float x) { return kindling::look_at(V3f(x, 5, 0), V3f(x, 0, 0), V3f(0, 0, 1)); };
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 0.5f;
  const std::vector<M44f> later{above(1.5f)};
  expect_mean_of_camera_paths(*world, {camera, above(-1.5f), V2i(16, 16), CameraMotion{later, true}}, 1024, 0.003);
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
  expect_mean_of_camera_paths(*world, open_camera(V2i(24, 24)), 256, 0.002);
}

} // namespace
} // namespace kindling::test
