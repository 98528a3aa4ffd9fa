// A scene of lights with a size: a sphere, a spot and a sun, with a veil and a thin wall.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/place_light.h"
#include "tests/integrator/test_scenes.h"
#include "tests/unbiased/scenes.h"

namespace kindling::test {

TestScene sized_lights() {
  const auto surface = [](const Rgb& color, float roughness, float metallic) {
    Material material = diffuse_material(color);
    material.specular_factor = 1.0f;
    material.roughness_factor = roughness;
    material.metallic_factor = metallic;
    return material;
  };
  Material veil = surface(Rgb(0.4f, 0.6f, 0.8f), 0.5f, 0.0f);
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.5f;
  Material thin_wall = surface(Rgb(0.9f, 0.7f, 0.5f), 0.0f, 0.0f);
  thin_wall.transmission_factor = 1.0f;
  veil.specular_factor = thin_wall.specular_factor = 0.0f; // rarely sampled reflections of lamps would be noise
  TestScene test;
  Scene scene = make_scene(
      {surface(Rgb(0.7f, 0.6f, 0.5f), 0.4f, 0.5f), surface(Rgb(0.5f, 0.6f, 0.7f), 0.6f, 0.0f), veil, thin_wall},
      {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0), quad(V3f(-3, 0, -3), V3f(6, 0, 0), V3f(0, 3, 0), 1),
       quad(V3f(-1.8f, 0.1f, -0.6f), V3f(1.2f, 0, 0.3f), V3f(0, 0.9f, 0), 2),
       quad(V3f(0.6f, 0.1f, 0.2f), V3f(1.0f, 0, 0.2f), V3f(0, 0.8f, 0), 3),
       sphere(V3f(0.2f, 0.5f, -0.8f), 0.5f, 24, 1)});
  PunctualLight sphere;
  sphere.intensity = 5.0f; // two emitters are chosen by intensity alone
  sphere.radius_m = 0.4f;
  const V3f sphere_at(-1.2f, 1.3f, -2.0f);
  place_light(scene, sphere, look_at(sphere_at, V3f(0.0f)));
  PunctualLight spot;
  spot.kind = PunctualLight::Kind::spot;
  spot.intensity = 8.0f;
  spot.inner_cone_rad = 0.3f;
  spot.outer_cone_rad = 0.6f;
  spot.radius_m = 0.45f;
  spot.range_m = 8.0f;
  const V3f spot_at(1.5f, 2.6f, 1.0f);
  place_light(scene, spot, look_at(spot_at, V3f(0.5f, 0, -0.5f)));
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 1.0f;
  sun.angular_diameter_rad = 0.5f;
  place_light(scene, sun, look_at(V3f(-2, 3, 4), V3f(0.0f)));

  test.camera.yfov_rad = 0.6f;
  test.camera_to_world = look_at(V3f(0.6f, 1.5f, 4.5f), V3f(-0.2f, 0.5f, -1));
  test.whole = {std::move(scene), std::make_shared<Environment>(Rgb(0.1f, 0.12f, 0.15f))};
  for (size_t emitting = 0; emitting < 4; ++emitting) { // each light, then the sky
    Part part{test.whole.scene, emitting == 3 ? test.whole.environment : nullptr};
    for (size_t i = 0; i < 3; ++i)
      if (i != emitting) part.scene.lights[i].intensity = 0.0f;
    test.parts.push_back(std::move(part));
  }
  test.max_bounces = 0; // light with more reflections would be too noisy
  test.samples = 28;
  test.traced_bounces = {0};
  test.traced_samples = 80;
  test.aims = {AimSphere{sphere_at, 0.4f}, AimSphere{spot_at, 0.45f},
               AimCone{V3f(-2, 3, 4).normalized(), 2.0f * square(std::sin(0.125f))}};
  test.bias = [](IntegratorSettings& settings) { settings.clamp_direct = 1.5f; };
  return test;
}

} // namespace kindling::test
