// A floor in water, which paths from the camera reach through its surface.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/place_light.h"
#include "tests/integrator/test_scenes.h"
#include "tests/sampling/estimate.h"

#include <cstdint>
#include <functional>
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

// Expects that light of a sun without a size, which `brings_light` lets a render find on the floor,
// keeps the limits of bounces.
inline void expect_bounce_limits(const std::function<void(IntegratorSettings&)>& brings_light) {
  const auto world = make_world(floor_in_water(0.6f, 3.0f, 0.0f, V3f(0, 5, 0)), accel::Kind::kdtree);
  const auto light = [&](int max_diffuse, int max_glossy, int max_transmission) {
    RenderSettings settings = small_render(V2i(8, 8), 4);
    brings_light(settings.integrator);
    settings.integrator.max_diffuse_bounces = max_diffuse;
    settings.integrator.max_glossy_bounces = max_glossy;
    settings.integrator.max_transmission_bounces = max_transmission;
    return render_mean(*world, camera_above(settings.size_px), settings).luminance;
  };
  const double once = light(1, 0, 2);
  EXPECT_GT(once, 0.1);
  EXPECT_EQ(light(0, 0, 2), 0.0);          // the floor is a diffuse bounce
  EXPECT_EQ(light(1, 0, 0), 0.0);          // the camera's ray does not reach it
  EXPECT_EQ(light(1, 0, 1), once);         // the last transmission, to the light, needs no further one
  EXPECT_GT(light(2, 2, 4), once + 0.001); // by the underside of the surface
}

} // namespace kindling::test
