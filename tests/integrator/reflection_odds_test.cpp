// Reflection of an environment in clear glass: means that are known on paper, and their noise.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/slabs_of_media.h"
#include "tests/light/light_fixtures.h"

#include <gtest/gtest.h>

namespace kindling::test {
namespace {

constexpr float kLamp = 50.0f; // radiance of the upper half of the sky; the lower half is dark

std::shared_ptr<const Environment> half_bright_sky() {
  return std::make_shared<Environment>(float_image(16, 8, [](int, int y) { return Rgb(y < 4 ? kLamp : 0.0f); }), 0.0f,
                                       1.0f);
}

// All rays go straight down, to a horizontal surface in the middle of a patch that fills the image,
// and are mirrored to the zenith.
Mean seen_from_above(const Scene& scene, const Camera& camera) {
  const auto world = make_world(scene, accel::Kind::kdtree, half_bright_sky());
  return render_mean(*world, camera, small_render({16, 16}, 64));
}

Camera straight_down() {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 0.5f;
  return {camera, kindling::look_at(V3f(0, 3, 0), V3f(0.0f), V3f(0, 0, -1)), {16, 16}};
}

Primitive floor_of(int material) { return quad(V3f(-2, 0, 2), V3f(4, 0, 0), V3f(0, 0, -4), material); }

// Glass of index 1.5 reflects 0.04 of the light at normal incidence.
constexpr double kReflectance = 0.04;

// The standard error of a fraction that is found with this probability, and of its light.
double error_of_choice(double light, double probability, int samples) {
  return light * std::sqrt((1.0 / probability - 1.0) / samples);
}

void expect_reflection(const Mean& mean, int samples) {
  const double light = kReflectance * static_cast<double>(kLamp);
  EXPECT_NEAR(mean.luminance, light, 4.5 * mean.standard_error + 1e-4 * light);
  // The sky is twice as bright in that direction as it is on average: odds of 0.04 to 0.96 become
  // 0.08 to 0.96, of 1 in 13.
  EXPECT_NEAR(mean.standard_error, error_of_choice(light, 1.0 / 13.0, samples), 0.1 * mean.standard_error);
  EXPECT_LT(mean.standard_error, 0.8 * error_of_choice(light, kReflectance, samples));
}

// What enters is absorbed, so all light is the mirrored sky.
TEST(ReflectionOdds, DeepWaterMirrorsTheSky) {
  const Mean mean = seen_from_above(make_scene({absorbing(1.5f, Rgb(0.001f), 1e-3f)}, {floor_of(0)}), straight_down());
  expect_reflection(mean, 16 * 16 * 64);
}

// A thin wall of clear glass before the dark half of the sky.
TEST(ReflectionOdds, ThinWallsMirrorTheSky) {
  Material thin_wall = glass(1.5f);
  thin_wall.thickness_factor = 0.0f;
  const Mean mean = seen_from_above(make_scene({thin_wall}, {floor_of(0)}), straight_down());
  expect_reflection(mean, 16 * 16 * 64);
}

} // namespace
} // namespace kindling::test
