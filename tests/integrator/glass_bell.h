// A sphere under a bell of glass, which light from a bright place of the sky reaches by refraction.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/test_scenes.h"
#include "tests/light/light_fixtures.h"

#include <memory>
#include <utility>

namespace kindling::test {

// A sphere that is seen from inside: its front faces are there.
inline Primitive hollow(const V3f& center, float radius, int slices, int material) {
  Primitive primitive = sphere(center, radius, slices, material);
  for (size_t i = 0; i < primitive.indices.size(); i += 3)
    std::swap(primitive.indices[i + 1], primitive.indices[i + 2]);
  for (V3f& normal : primitive.normals) normal = -normal;
  return primitive;
}

// The bell has two walls, 1 and 0.95 m around the origin; the floor below it is in the open.
inline Scene sphere_under_a_bell() {
  return make_scene({diffuse_material(Rgb(0.7f, 0.6f, 0.5f)), glass_material(0.0f)},
                    {sphere(V3f(0.0f), 0.5f, 32, 0), sphere(V3f(0.0f), 1.0f, 32, 1), hollow(V3f(0.0f), 0.95f, 32, 1),
                     quad(V3f(-3, -1.2f, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0)});
}

// Dark but for a lamp of `radiance` over 17 degrees, up and to the side.
inline std::shared_ptr<const Environment> sky_with_a_lamp(float radiance) {
  return std::make_shared<Environment>(float_image(64, 32,
                                                   [radiance](int x, int y) {
                                                     return x >= 20 && x < 23 && y >= 6 && y < 9
                                                                ? Rgb(radiance, radiance, 0.8f * radiance)
                                                                : Rgb(0.1f, 0.12f, 0.15f);
                                                   }),
                                       0.0f, 1.0f);
}

inline std::unique_ptr<const World> bell_world(accel::Kind kind = accel::Kind::kdtree) {
  return make_world(sphere_under_a_bell(), kind, sky_with_a_lamp(60.0f));
}

// Sees the bell and some of the floor.
inline Camera bell_camera(const V2i& size_px) {
  SceneCamera camera;
  camera.yfov_rad = 0.7f;
  return {camera, look_at(V3f(0, 0.8f, 4.2f), V3f(0, -0.1f, 0)), size_px};
}

} // namespace kindling::test
