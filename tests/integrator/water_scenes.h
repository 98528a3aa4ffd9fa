// A floor in water, which paths from the camera reach through its surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/place_light.h"
#include "tests/integrator/test_scenes.h"
#include "tests/sampling/estimate.h"

#include <cstdint>
#include <utility>

namespace kindling::test {

// A closed box of water whose sides and bottom are outside of what the tests see.
inline Primitive water_box(int material) {
  Primitive box;
  box.material = material;
  const auto corner = [](int i) {
    return V3f((i & 1) != 0 ? 4.0f : -4.0f, (i & 2) != 0 ? 1.0f : -0.5f, (i & 4) != 0 ? 4.0f : -4.0f);
  };
  for (int i = 0; i < 8; ++i) box.positions.push_back(corner(i));
  box.indices = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  return box;
}

inline Material water_material() {
  Material water = glass_material(0.0f);
  water.ior = 1.33f;
  return water;
}

// A floor in water, below a sun.
inline Scene floor_in_water(float rho, float irradiance, float sun_angle_deg, const V3f& sun_from) {
  Scene scene = make_scene({diffuse_material(Rgb(rho)), water_material()},
                           {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0), water_box(1)});
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = irradiance;
  if (sun_angle_deg > 0.0f) sun.angular_diameter_rad = sun_angle_deg * kPi / 180.0f;
  place_light(scene, sun, kindling::look_at(sun_from, V3f(0.0f), V3f(0, 0, 1)));
  return scene;
}

// A camera that looks straight down.
inline Camera camera_above(const V2i& size_px) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 0.5f;
  return {camera, kindling::look_at(V3f(0, 5, 0), V3f(0.0f), V3f(0, 0, 1)), size_px};
}

inline Estimate estimate_means(const World& world, const Camera& camera, RenderSettings settings, uint32_t seeds) {
  Estimate means;
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    settings.seed += 100;
    means.add(render_mean(world, camera, settings).luminance);
  }
  return means;
}

} // namespace kindling::test
