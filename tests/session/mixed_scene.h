// Small scenes with all features, for renders that must agree to the bit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/integrator/motion_scenes.h"
#include "tests/integrator/place_light.h"

namespace kindling::test {

inline Scene mixed_scene() {
  Scene scene = sphere_lamp_and_veil(0.3f);
  // A second sphere by instancing.
  Node copy = scene.nodes[0];
  copy.local.translation = V3f(-2.2f, 0, 0.3f);
  copy.local.scale = V3f(1.0f, 0.5f, -1.0f);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(copy);
  // A dispersive, cloudy sphere and a thin wall before everything.
  Material opal;
  opal.metallic_factor = 0.0f;
  opal.roughness_factor = 0.2f;
  opal.transmission_factor = opal.thickness_factor = opal.clearcoat_factor = opal.dispersion = 1.0f;
  opal.attenuation_distance_m = 0.5f;
  opal.attenuation_color = Rgb(0.9f, 0.7f, 0.4f);
  opal.multiscatter_color = Rgb(0.4f, 0.3f, 0.2f);
  Material thin_wall;
  thin_wall.metallic_factor = thin_wall.roughness_factor = 0.0f;
  thin_wall.transmission_factor = 1.0f;
  thin_wall.base_color_factor = V4f(0.8f, 0.9f, 0.7f, 1.0f);
  add_object(scene, opal, sphere(V3f(0.9f, -0.4f, 1.6f), 0.6f, 16, 0));
  add_object(scene, thin_wall, quad(V3f(-3, -0.9f, 2.5f), V3f(4, 0, 0), V3f(0, 3, 0), 0));
  return scene;
}

// A glass sphere over a floor, under a square lamp of a meter, with a mirror beside it.
inline Scene lamp_scene() {
  Material glass = diffuse_material(Rgb(1.0f)), mirror = glass;
  glass.roughness_factor = 0.1f;
  glass.specular_factor = 1.0f;
  glass.transmission_factor = glass.thickness_factor = 1.0f;
  mirror.metallic_factor = 1.0f;
  mirror.roughness_factor = 0.0f;
  return make_scene({diffuse_material(Rgb(0.7f)), glass, emissive_material(Rgb(30.0f)), mirror},
                    {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 32, 1),
                     quad(V3f(-0.5f, 5, -0.5f), V3f(1, 0, 0), V3f(0, 0, 1), 2),
                     quad(V3f(-2, 0, 3), V3f(0, 0, -6), V3f(0, 3, 0), 3)});
}
inline std::unique_ptr<const World> lamp_world(accel::Kind kind) { return make_world(lamp_scene(), kind); }

// The same, and the mirror reflects a sun without a size, which only light paths find.
inline Scene glass_scene() {
  Scene scene = lamp_scene();
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 3.0f;
  place_light(scene, sun, look_at(V3f(5, 5, 0), V3f(0.0f)));
  return scene;
}
inline std::unique_ptr<const World> glass_world(accel::Kind kind) { return make_world(glass_scene(), kind); }

// The same with smooth glass, which manifold sampling finds the sun through.
inline std::unique_ptr<const World> smooth_glass_world(accel::Kind kind) {
  Scene scene = glass_scene();
  scene.materials[1].roughness_factor = 0.0f;
  return make_world(std::move(scene), kind);
}

// The same while the sphere rises and swells, the lamp moves and the mirror turns.
inline std::unique_ptr<const World> moving_glass_world(accel::Kind kind) {
  Scene scene = glass_scene();
  add_morph(scene, 1, [](const V3f& p) { return V3f(0.3f * p.x, 0.2f, 0); });
  animate(scene, 2, AnimatedProperty::translation, {0, 1}, {-0.5f, 0, 0, 0.8f, -0.5f, 0.5f});
  animate_turn(scene, 3, V3f(0, 1, 0), 10.0f);
  return make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, kind);
}

inline Camera glass_camera(const V2i& size_px) {
  SceneCamera camera;
  camera.yfov_rad = 0.6f;
  return {camera, look_at(V3f(0, 4, 7), V3f(0, 0.3f, 0)), size_px};
}
inline Camera moving_glass_camera(const V2i& size_px) {
  SceneCamera camera;
  camera.yfov_rad = 0.6f;
  const std::vector<M44f> later{look_at(V3f(0.4f, 4, 6.8f), V3f(0.1f, 0.4f, 0))};
  return {camera, look_at(V3f(0, 4, 7), V3f(0, 0.3f, 0)), size_px, CameraMotion{later, true}};
}

// Names for the nodes and materials of any small scene: Node_0, Material_0 and so on; the node with
// an odd number is below the one before it.
inline std::shared_ptr<const SurfaceNames> numbered_names() {
  auto names = std::make_shared<SurfaceNames>();
  for (int i = 0; i < 32; ++i) {
    names->nodes.push_back("Node_" + std::to_string(i));
    names->roots.push_back(i & ~1);
    names->has_mesh.push_back(1);
    names->materials.push_back("Material_" + std::to_string(i));
  }
  return names;
}

// Adds all mattes to the settings of a path tracer.
inline void add_mattes(RenderSettings& settings) {
  for (const MatteInfo& info : kMattes) settings.aovs.insert(info.matte);
  settings.names = numbered_names();
}

// Adds all AOVs that need nothing but a World and a camera.
inline void add_aovs_of_camera(RenderSettings& settings) {
  for (const AovInfo& info : kAovs)
    if (!is_motion(info.aov) && info.aov != Aov::shadow_catcher) settings.aovs.insert(info.aov);
}

inline std::unique_ptr<const World> mixed_world(accel::Kind kind) {
  return make_world(mixed_scene(), kind, std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
}

// A turning sphere, a second one of the same mesh that is static, a lamp that swings, a bending
// strip, and a moving veil.
inline std::unique_ptr<const World> moving_world(accel::Kind kind) {
  Scene scene = sphere_lamp_and_veil(0.3f);
  Node copy = scene.nodes[0];
  copy.local.translation = V3f(-2.2f, 0, 0.3f);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(copy);
  animate_turn(scene, 0, V3f(0, 0.6f, 0.8f), 90.0f);
  animate(scene, 2, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 1, 0.3f, 0});
  animate(scene, 3, AnimatedProperty::translation, {0, 1}, {0, 0, 0, -0.5f, 0, 0});
  Node bent;
  bent.mesh = static_cast<int>(scene.meshes.size());
  scene.meshes.push_back({.primitives = {jointed_strip(8, 1)}});
  const auto strip = static_cast<int>(scene.nodes.size());
  scene.scenes[0].nodes.push_back(strip);
  scene.nodes.push_back(bent);
  add_bending_skin(scene, strip, V3f(0.6f, 0, 0.8f), 80.0f);
  return make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, kind,
                          std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
}

} // namespace kindling::test
