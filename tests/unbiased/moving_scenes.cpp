// Scenes that move while the shutter is open: surfaces that focus light, lamps, the camera.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/motion_scenes.h"
#include "tests/integrator/place_light.h"
#include "tests/unbiased/scenes.h"

namespace kindling::test {

namespace {

// The lamp of `light` moves from one point to another.
void add_moving_light(Scene& scene, const PunctualLight& light, const V3f& from, const V3f& to) {
  Node node;
  node.light = static_cast<int>(scene.lights.size());
  node.local.translation = from;
  scene.lights.push_back(light);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  animate(scene, static_cast<int>(scene.nodes.size()) - 1, AnimatedProperty::translation, {0, 1},
          {from.x, from.y, from.z, to.x, to.y, to.z});
}

PunctualLight lamp(float intensity, float radius) {
  PunctualLight light;
  light.intensity = intensity;
  light.radius_m = radius;
  return light;
}

// A floor and a wall, a square lamp (node 2), two spheres of glass (3 and 4) and one of metal (5).
Scene glass_and_metal() {
  return make_scene(
      {diffuse_material(Rgb(0.7f, 0.6f, 0.5f)), emissive_material(Rgb(6.0f, 5.0f, 4.0f)), glass_material(0.0f),
       glass_material(0.25f), metal_material(Rgb(0.9f, 0.7f, 0.4f), 0.3f)},
      {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0), quad(V3f(-3, 0, -3), V3f(6, 0, 0), V3f(0, 3, 0), 0),
       quad(V3f(-1.6f, 2.6f, -0.6f), V3f(1.2f, 0, 0), V3f(0, 0, 1.2f), 1), sphere(V3f(-0.9f, 0.7f, 0), 0.5f, 48, 2),
       sphere(V3f(0.3f, 0.7f, 0), 0.5f, 48, 3), sphere(V3f(1.4f, 0.6f, -0.6f), 0.5f, 48, 4)});
}

TestScene seen_for_a_second(Scene scene, uint32_t samples) {
  TestScene test = seen_from_above(std::move(scene), samples);
  test.shutter = Shutter{0.0, 1.0};
  return test;
}

} // namespace

TestScene moving_caustics() {
  Scene scene = glass_and_metal();
  animate(scene, 3, AnimatedProperty::translation, {0, 1}, {-0.3f, 0, 0.3f, 0.5f, 0.4f, 0.6f});
  add_morph(scene, 4, [](const V3f& p) { return V3f(0.4f * (p.x - 0.3f), 0.3f, 0.5f * p.z); });
  animate(scene, 5, AnimatedProperty::scale, {0, 1}, {1, 1, 1, 0.8f, 1.3f, 1});
  animate_turn(scene, 5, V3f(0, 1, 0), 40.0f);
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 2.5f;
  sun.angular_diameter_rad = 0.8f;
  place_light(scene, sun, look_at(V3f(-2, 4, 1), V3f(0.0f)));
  TestScene test = seen_for_a_second(std::move(scene), 34);
  test.later_cameras = {look_at(V3f(0.5f, 2.3f, 4.3f), V3f(0.2f, 0.4f, 0)),
                        look_at(V3f(0.6f, 2.0f, 4.0f), V3f(-0.1f, 0.5f, 0))};
  return test;
}

TestScene moving_lamps() {
  Scene scene = glass_and_metal();
  animate(scene, 2, AnimatedProperty::translation, {0, 1}, {-0.4f, 0, 0, 0.8f, 0.3f, 0.6f});
  animate(scene, 2, AnimatedProperty::scale, {0, 1}, {1, 1, 1, 0.7f, 1, 1.2f});
  add_moving_light(scene, lamp(3.0f, 0.5f), V3f(0.6f, 2.9f, 1.2f), V3f(1.8f, 2.2f, 0.2f));
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 1.0f;
  sun.angular_diameter_rad = 0.6f;
  Node node;
  node.light = static_cast<int>(scene.lights.size());
  scene.lights.push_back(sun);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  // Turned about x from straight ahead, along -z, to 50 and 80 degrees downwards.
  const auto half_turn = [](float degrees) { return -degrees * kPi / 360.0f; };
  animate(
      scene, static_cast<int>(scene.nodes.size()) - 1, AnimatedProperty::rotation, {0, 1},
      {std::sin(half_turn(50)), 0, 0, std::cos(half_turn(50)), std::sin(half_turn(80)), 0, 0, std::cos(half_turn(80))});
  return seen_for_a_second(std::move(scene), 30);
}

} // namespace kindling::test
