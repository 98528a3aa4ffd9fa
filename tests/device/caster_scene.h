// A small scene with surfaces that focus light, of all kinds, under lights of all kinds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/place_light.h"
#include "tests/integrator/test_scenes.h"
#include "tests/light/light_fixtures.h"

#include <memory>
#include <utility>

namespace kindling::test {

// Glass, a prism, metal and a coat over a floor, behind a thin wall; with `cut_out` a face with
// partial coverage, so that rays ask for it. The sun, lamps with and without a size, and a bright
// place of the sky.
inline std::unique_ptr<const World> caster_world(bool cut_out) {
  Material coated = diffuse_material(Rgb(0.8f, 0.2f, 0.2f));
  coated.clearcoat_factor = 1.0f;
  coated.clearcoat_roughness_factor = 0.1f;
  Material prism = glass_material(0.0f);
  prism.dispersion = 3.0f;
  Material tinted = glass_material(0.15f);
  tinted.attenuation_distance_m = 0.5f;
  tinted.attenuation_color = Rgb(0.9f, 0.7f, 0.4f);
  Scene scene = make_scene(
      {diffuse_material(Rgb(0.7f)), coated, prism, tinted, metal_material(Rgb(0.9f, 0.6f, 0.3f), 0.2f),
       emissive_material(Rgb(30.0f, 25.0f, 20.0f)), glossy_material(Rgb(0.2f, 0.3f, 0.8f), 0.1f)},
      {quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0), sphere(V3f(-2.2f, -0.2f, 0.3f), 0.8f, 24, 1),
       sphere(V3f(-0.6f, -0.3f, 1.0f), 0.7f, 6, 2, false), sphere(V3f(0.9f, -0.3f, 0.9f), 0.7f, 24, 3),
       sphere(V3f(2.3f, -0.2f, 0.1f), 0.8f, 24, 4), quad(V3f(-0.5f, 4, -0.5f), V3f(1, 0, 0), V3f(0, 0, 1), 5),
       quad(V3f(-3, -1, -2), V3f(6, 0, 0), V3f(0, 3, 0), 6)});
  if (cut_out) {
    Material veil = diffuse_material(Rgb(0.8f)), thin_wall = glass_material(0.0f);
    veil.alpha_mode = AlphaMode::blend;
    veil.base_color_factor.w = 0.5f;
    add_object(scene, veil, quad(V3f(1.0f, -1, 1.8f), V3f(1, 0, 0), V3f(0, 1.5f, 0), 0));
    thin_wall.thickness_factor = 0.0f;
    thin_wall.base_color_factor = V4f(0.8f, 0.9f, 0.7f, 1.0f);
    add_object(scene, thin_wall, quad(V3f(-3, -0.9f, 2.5f), V3f(4, 0, 0), V3f(0, 3, 0), 0));
    add_object(scene, thin_wall, quad(V3f(-3, 2.5f, 2), V3f(6, 0, 0), V3f(0, 0, -4), 0));
  }
  PunctualLight sun, lamp, spot;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 2.0f;
  place_light(scene, sun, look_at(V3f(3, 5, 2), V3f(0.0f)));
  sun.angular_diameter_rad = 0.02f;
  place_light(scene, sun, look_at(V3f(-3, 5, 3), V3f(0.0f)));
  lamp.intensity = 15.0f;
  place_light(scene, lamp, look_at(V3f(-2, 3, 2), V3f(0.0f)));
  lamp.radius_m = 0.2f;
  place_light(scene, lamp, look_at(V3f(2, 3, 2), V3f(0.0f)));
  spot.kind = PunctualLight::Kind::spot;
  spot.intensity = 40.0f;
  place_light(scene, spot, look_at(V3f(1, 3.5f, 3), V3f(1, -1, 0)));
  const auto sky = float_image(32, 16, [](int x, int y) {
    return x >= 20 && x < 22 && y >= 3 && y < 5 ? Rgb(60.0f, 50.0f, 40.0f) : Rgb(0.2f, 0.25f, 0.3f);
  });
  return make_world(std::move(scene), accel::Kind::kdtree, std::make_shared<Environment>(sky, 0.0f, 1.0f));
}

} // namespace kindling::test
