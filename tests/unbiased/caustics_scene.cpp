// Scenes of surfaces that focus light: glass, metal, coats, prisms.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/glass_bell.h"
#include "tests/integrator/place_light.h"
#include "tests/integrator/test_scenes.h"
#include "tests/unbiased/scenes.h"

namespace kindling::test {

namespace {

Material tinted_glass(float roughness) {
  Material material = glass_material(roughness);
  material.attenuation_distance_m = 1.5f;
  material.attenuation_color = Rgb(0.6f, 0.8f, 0.9f);
  return material;
}

void add_lamp(Scene& scene, float intensity, float radius, const V3f& at) {
  PunctualLight lamp;
  lamp.intensity = intensity;
  lamp.radius_m = radius;
  place_light(scene, lamp, look_at(at, V3f(0.0f)));
}

} // namespace

TestScene seen_from_above(Scene scene, uint32_t samples) {
  TestScene test;
  test.camera.yfov_rad = 0.6f;
  test.camera_to_world = look_at(V3f(0.2f, 2.2f, 4.5f), V3f(0.1f, 0.4f, 0));
  test.whole = {std::move(scene), nullptr};
  test.max_bounces = 4;
  test.samples = samples;
  test.casters = true;
  test.bias = [](IntegratorSettings& settings) { settings.caustics = Caustics::off; };
  return test;
}

TestScene caustics() {
  Material window = tinted_glass(0.0f);
  window.base_color_factor = V4f(0.7f, 0.8f, 0.6f, 1.0f);
  window.thickness_factor = 0.0f;
  Scene scene = make_scene(
      {diffuse_material(Rgb(0.7f, 0.6f, 0.5f)), emissive_material(Rgb(6.0f, 5.0f, 4.0f)), tinted_glass(0.0f),
       tinted_glass(0.25f), metal_material(Rgb(0.9f, 0.7f, 0.4f), 0.3f), window},
      {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0), quad(V3f(-3, 0, -3), V3f(6, 0, 0), V3f(0, 3, 0), 0),
       quad(V3f(-1.6f, 2.6f, -0.6f), V3f(1.2f, 0, 0), V3f(0, 0, 1.2f), 1), sphere(V3f(-0.9f, 0.7f, 0), 0.5f, 48, 2),
       sphere(V3f(0.3f, 0.7f, 0), 0.5f, 48, 3), sphere(V3f(1.4f, 0.6f, -0.6f), 0.5f, 48, 4),
       quad(V3f(-0.1f, 1.5f, 0.6f), V3f(1.2f, 0, 0), V3f(0, 0.2f, -1.2f), 5)});
  add_lamp(scene, 3.0f, 0.5f, V3f(1.0f, 2.6f, 0.8f));
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 1.0f;
  sun.angular_diameter_rad = 0.6f;
  place_light(scene, sun, look_at(V3f(-2, 4, 1), V3f(0.0f)));
  return seen_from_above(std::move(scene), 30);
}

// The floor is glossy, so that its reflections divide the light that light paths bring there.
TestScene coats_and_prisms() {
  Material coated = diffuse_material(Rgb(0.6f, 0.1f, 0.1f));
  coated.clearcoat_factor = 1.0f;
  coated.clearcoat_roughness_factor = 0.3f;
  Material prism = tinted_glass(0.0f), frosted_prism = tinted_glass(0.2f);
  prism.dispersion = frosted_prism.dispersion = 2.0f;
  Scene scene = make_scene({glossy_material(Rgb(0.6f, 0.5f, 0.4f), 0.3f), diffuse_material(Rgb(0.7f)),
                            emissive_material(Rgb(3.0f, 2.5f, 2.0f)), prism, frosted_prism, coated,
                            glossy_material(Rgb(0.1f, 0.2f, 0.4f), 0.25f)},
                           {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0),
                            quad(V3f(-3, 0, -3), V3f(6, 0, 0), V3f(0, 3, 0), 1),
                            quad(V3f(-2.4f, 2.9f, -1.4f), V3f(2.4f, 0, 0), V3f(0, 0, 2.4f), 2),
                            sphere(V3f(-0.9f, 0.7f, 0), 0.5f, 48, 3), sphere(V3f(0.3f, 0.7f, 0), 0.5f, 48, 4),
                            sphere(V3f(1.4f, 0.6f, -0.6f), 0.5f, 48, 5), sphere(V3f(-0.3f, 0.5f, 1.0f), 0.4f, 48, 6)});
  add_lamp(scene, 4.0f, 0.8f, V3f(1.4f, 2.9f, 0.8f));
  return seen_from_above(std::move(scene), 40);
}

TestScene glass_bell() {
  TestScene test = seen_from_above(sphere_under_a_bell(), 40);
  test.whole.environment = sky_with_a_lamp(6.0f);
  return test;
}

} // namespace kindling::test
