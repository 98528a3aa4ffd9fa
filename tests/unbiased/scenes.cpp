// Builds the procedural test scenes and loads the shipped ones.
// SPDX-License-Identifier: Apache-2.0
#include "tests/unbiased/scenes.h"

#include "renderer/import/load_gltf.h"
#include "tests/integrator/place_light.h"
#include "tests/integrator/test_scenes.h"
#include "tests/light/light_fixtures.h"

namespace kindling::test {
namespace {

Material surface_material(const Rgb& color, float roughness, float metallic) {
  Material material;
  material.base_color_factor = V4f(color.x, color.y, color.z, 1.0f);
  material.roughness_factor = roughness;
  material.metallic_factor = metallic;
  material.double_sided = true;
  return material;
}

Material veil_material(const Rgb& color, float alpha) {
  Material material = surface_material(color, 0.5f, 0.0f);
  material.alpha_mode = AlphaMode::blend;
  material.base_color_factor.w = alpha;
  return material;
}

// Adds a primitive as a mesh of its own, without a node.
int add_mesh(Scene& scene, Primitive primitive) {
  Mesh mesh;
  mesh.primitives.push_back(std::move(primitive));
  scene.meshes.push_back(std::move(mesh));
  return static_cast<int>(scene.meshes.size()) - 1;
}

// Returns the scene with only material number `material` (kNone: none) and light number `light`
// emitting.
Scene lit_by(Scene scene, int material, int light) {
  for (size_t i = 0; i < scene.materials.size(); ++i)
    if (static_cast<int>(i) != material) {
      scene.materials[i].emissive_factor = Rgb(0.0f);
      scene.materials[i].emissive_texture = {};
    }
  for (size_t i = 0; i < scene.lights.size(); ++i)
    if (static_cast<int>(i) != light) scene.lights[i].intensity = 0.0f;
  return scene;
}

// Returns one part for each emissive material, each light and the environment.
std::vector<Part> light_by_light(const Part& whole) {
  std::vector<Part> parts;
  for (size_t i = 0; i < whole.scene.materials.size(); ++i)
    if (!is_black(whole.scene.materials[i].emissive_factor))
      parts.push_back({lit_by(whole.scene, static_cast<int>(i), kNone), nullptr});
  for (size_t i = 0; i < whole.scene.lights.size(); ++i)
    parts.push_back({lit_by(whole.scene, kNone, static_cast<int>(i)), nullptr});
  if (whole.environment) parts.push_back({lit_by(whole.scene, kNone, kNone), whole.environment});
  return parts;
}

// An image of random colored texels.
SceneTexture patchy_texture() {
  Random random(11);
  SceneTexture texture;
  texture.image = float_image(8, 8, [&](int x, int y) {
    const float level = (x + y) % 3 == 0 ? 0.2f : 0.5f + 0.5f * random.next_1d();
    return Rgb(level, level * 0.8f, level * random.next_1d());
  });
  return texture;
}

void look(TestScene& scene, const V3f& eye, const V3f& target, float yfov_rad) {
  scene.camera.yfov_rad = yfov_rad;
  scene.camera_to_world = look_at(eye, target);
}

TestScene shipped(const char* name) {
  Result<Scene> loaded = load_gltf(std::string(KINDLING_SOURCE_DIR "/scenes/") + name, {}, nullptr);
  EXPECT_TRUE(loaded.ok());
  TestScene scene;
  scene.whole.scene = std::move(loaded).value();
  const PosedCamera posed = pose_scene(scene.whole.scene, {}).value().cameras.at(0);
  scene.camera = scene.whole.scene.cameras.at(static_cast<size_t>(posed.camera));
  scene.camera_to_world = posed.camera_to_world;
  return scene;
}

} // namespace

TestScene hall_of_lamps() {
  TestScene test;
  std::vector<Material> materials{surface_material(Rgb(0.6f, 0.5f, 0.4f), 0.5f, 0.0f), diffuse_material(Rgb(0.5f))};
  for (const float strength : {0.8f, 1.0f, 1.2f, 2.0f})
    materials.push_back(emissive_material(Rgb(strength, strength * 0.8f, strength * 0.5f), Rgb(0.3f)));
  materials.back().emissive_texture.texture = 0;
  Scene scene = make_scene(std::move(materials), {quad(V3f(-8, 0, 4), V3f(16, 0, 0), V3f(0, 0, -12), 0),
                                                  quad(V3f(-8, 0, -8), V3f(16, 0, 0), V3f(0, 4, 0), 1)});
  scene.textures.push_back(patchy_texture());
  int spheres[4];
  for (int kind = 0; kind < 4; ++kind) {
    Primitive primitive = sphere(V3f(0.0f), 0.3f, 8, 2 + kind);
    primitive.texcoords.emplace_back();
    for (const V3f& p : primitive.positions) primitive.texcoords[0].emplace_back(p.x * 2.0f, p.y * 3.0f);
    spheres[kind] = add_mesh(scene, std::move(primitive));
  }
  for (int i = 0; i < 18; ++i)
    for (int j = 0; j < 12; ++j) {
      Node node;
      node.mesh = spheres[(i * 5 + j * 3) % 7 % 4];
      node.local.translation = V3f(-6.8f + 0.8f * static_cast<float>(i), 2.6f + 0.3f * static_cast<float>((i + j) % 3),
                                   2.0f - 0.8f * static_cast<float>(j));
      scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
      scene.nodes.push_back(node);
    }
  look(test, V3f(0.5f, 1.7f, 3.5f), V3f(0, 0.1f, -3), 0.6f);
  test.whole = {std::move(scene), nullptr};
  test.max_bounces = 0;
  test.traced_bounces = {0};
  test.aims = {AimRectangle{V3f(-7.1f, 2.9f, 2.3f), V3f(14.2f, 0, 0), V3f(0, 0, -9.4f)}};
  test.traced_samples = 72;
  test.samples = 10;
  test.bias = [](IntegratorSettings& settings) { settings.clamp_direct = 0.4f; };
  return test;
}

TestScene room_with_window() {
  TestScene test;
  Scene scene = make_scene(
      {diffuse_material(Rgb(0.7f, 0.6f, 0.5f)), surface_material(Rgb(0.5f, 0.6f, 0.7f), 0.4f, 0.0f),
       surface_material(Rgb(0.9f, 0.7f, 0.4f), 0.5f, 1.0f)},
      {quad(V3f(-2, 0, 1), V3f(4, 0, 0), V3f(0, 0, -4), 1), quad(V3f(-2, 2.5f, 1), V3f(4, 0, 0), V3f(0, 0, -4), 0),
       quad(V3f(-2, 0, -3), V3f(4, 0, 0), V3f(0, 2.5f, 0), 0), quad(V3f(-2, 0, 1), V3f(4, 0, 0), V3f(0, 2.5f, 0), 0),
       quad(V3f(-2, 0, -3), V3f(0, 0, 4), V3f(0, 2.5f, 0), 0),
       // The wall at x = 2 around its opening.
       quad(V3f(2, 0, -3), V3f(0, 0, 4), V3f(0, 0.2f, 0), 0), quad(V3f(2, 2.3f, -3), V3f(0, 0, 4), V3f(0, 0.2f, 0), 0),
       quad(V3f(2, 0.2f, -3), V3f(0, 0, 0.3f), V3f(0, 2.1f, 0), 0),
       quad(V3f(2, 0.2f, 0.5f), V3f(0, 0, 0.5f), V3f(0, 2.1f, 0), 0), sphere(V3f(0.2f, 0.5f, -1.5f), 0.5f, 24, 2)});
  // The environment is bright above the horizon towards +x, where the window is.
  const auto sky = float_image(32, 16, [](int x, int y) {
    if (y >= 8 || x < 11 || x > 21) return Rgb(0.2f, 0.2f, 0.15f);
    return x >= 17 && x < 20 && y >= 4 && y < 7 ? Rgb(9.0f, 8.0f, 6.0f) : Rgb(1.6f, 2.0f, 2.4f);
  });
  look(test, V3f(-1.2f, 1.4f, 0.9f), V3f(0.2f, 0.9f, -2), 1.0f);
  test.whole = {std::move(scene), std::make_shared<Environment>(sky, 0.0f, 1.0f)};
  test.max_bounces = 2;
  test.traced_bounces = {2};
  test.aims = {AimRectangle{V3f(2, 0.2f, -2.7f), V3f(0, 0, 3.2f), V3f(0, 2.1f, 0)}};
  test.traced_samples = 60;
  test.samples = 10;
  test.bias = [](IntegratorSettings& settings) { settings.clamp_indirect = 0.6f; };
  return test;
}

TestScene metal_under_sun() {
  TestScene test;
  Scene scene = make_scene(
      {surface_material(Rgb(0.5f, 0.5f, 0.6f), 0.6f, 0.0f), surface_material(Rgb(0.9f, 0.6f, 0.3f), 0.35f, 1.0f),
       surface_material(Rgb(0.9f), 0.5f, 1.0f), surface_material(Rgb(0.8f, 0.2f, 0.2f), 0.4f, 0.0f)},
      {quad(V3f(-6, 0, 4), V3f(12, 0, 0), V3f(0, 0, -10), 0), sphere(V3f(-2, 0.8f, 0), 0.8f, 24, 1),
       sphere(V3f(0, 0.8f, -1), 0.8f, 24, 2), sphere(V3f(1.8f, 0.7f, 0.3f), 0.7f, 24, 3)});
  // The sun is 2 x 2 texels around (41, 8) of 64 x 32: at u = 41/64 and 45 degrees above the
  // horizon. All values are exact in half precision, so that skies add up exactly.
  const auto sky_with = [](float sky, float sun) {
    return std::make_shared<Environment>(float_image(64, 32,
                                                     [=](int x, int y) {
                                                       if (x >= 40 && x < 42 && y >= 7 && y < 9)
                                                         return Rgb(1.0f, 0.875f, 0.75f) * (sun + sky);
                                                       const float level =
                                                           y < 16 ? 1.0f - static_cast<float>(y) / 32.0f : 0.25f;
                                                       return Rgb(0.5f, 0.75f, 1.0f) * (sky * level);
                                                     }),
                                         0.0f, 1.0f);
  };
  const float phi = 2.0f * kPi * (41.0f / 64.0f - 0.5f), s = std::sqrt(0.5f);
  look(test, V3f(0.5f, 2.0f, 6), V3f(0, 0.6f, 0), 0.7f);
  test.whole = {std::move(scene), sky_with(1.0f, 60.0f)};
  test.parts = {{test.whole.scene, sky_with(1.0f, 0.0f)}, {test.whole.scene, sky_with(0.0f, 60.0f)}};
  test.traced_bounces = {0, 1};
  test.aims = {AimCone{V3f(s * std::cos(phi), s, s * std::sin(phi)), 0.022f}};
  test.samples = 7;
  test.casters = true;
  test.bias = [](IntegratorSettings& settings) { settings.caustics = Caustics::off; };
  return test;
}

TestScene textured_emitters() {
  TestScene test;
  Material lamp = emissive_material(Rgb(4.0f, 3.0f, 2.0f), Rgb(0.2f));
  lamp.emissive_texture.texture = 0;
  lamp.emissive_texture.scale = V2f(1.5f, 0.7f);
  lamp.emissive_texture.rotation_rad = 0.4f;
  Scene scene = make_scene(
      {surface_material(Rgb(0.6f), 0.4f, 0.0f), diffuse_material(Rgb(0.7f, 0.5f, 0.3f)), lamp},
      {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0), quad(V3f(-3, 0, -3), V3f(6, 0, 0), V3f(0, 4, 0), 1)});
  scene.textures.push_back(patchy_texture());
  Node node{.mesh = add_mesh(scene, quad(V3f(-0.4f, 0, 0.3f), V3f(0.8f, 0, 0), V3f(0, 0, -0.6f), 2))};
  Random random(3);
  for (int i = 0; i < 4; ++i) // instances of one lamp, turned, stretched and mirrored
    for (int j = 0; j < 3; ++j) {
      Transform place;
      place.translation = V3f(-2.4f + 1.5f * static_cast<float>(i), 2.0f, -1.8f + 1.4f * static_cast<float>(j));
      const V3f drawn{random.next_1d(), random.next_1d(), random.next_1d()};
      place.rotation.setAxisAngle(V3f(drawn.x, 0.3f, drawn.y).normalized(), 0.8f * drawn.z);
      place.scale = V3f(0.7f + 0.6f * random.next_1d(), 1.0f, j == 1 ? -1.0f : 1.2f);
      node.gpu_instances.push_back(place);
    }
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  look(test, V3f(0.3f, 1.4f, 4), V3f(0, 0.1f, -1.5f), 0.6f);
  test.whole = {std::move(scene), std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f))};
  test.parts = light_by_light(test.whole);
  test.traced_bounces = {1};
  test.aims = {AimRectangle{V3f(-2.9f, 2, -2.2f), V3f(5.6f, 0, 0), V3f(0, 0, 3.6f)}};
  test.traced_samples = 40;
  test.samples = 6;
  test.bias = [](IntegratorSettings& settings) { settings.clamp_direct = 0.75f; };
  return test;
}

TestScene veils() {
  TestScene test;
  Material shining = veil_material(Rgb(0.3f, 0.5f, 0.3f), 0.5f);
  shining.emissive_factor = Rgb(0.4f, 0.6f, 0.3f);
  Scene scene = make_scene(
      {diffuse_material(Rgb(0.6f)), emissive_material(Rgb(5.0f, 4.0f, 3.0f)),
       veil_material(Rgb(0.8f, 0.3f, 0.2f), 0.3f), shining, veil_material(Rgb(0.2f, 0.3f, 0.8f), 0.6f)},
      {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), quad(V3f(-1.5f, 3, -1.5f), V3f(3, 0, 0), V3f(0, 0, 2), 1),
       // Above the floor, under the lamp, one over the other; and two that stand in the view.
       quad(V3f(-2, 1.8f, 1), V3f(4, 0, 0), V3f(0, 0, -3), 2),
       quad(V3f(-1, 1.4f, 1), V3f(3, 0.2f, 0), V3f(0, 0, -2), 4),
       quad(V3f(-2.5f, 0, 0.5f), V3f(2, 0, 0.5f), V3f(0, 1.5f, 0), 3),
       quad(V3f(-1.5f, 0, 1.5f), V3f(2.5f, 0, 0), V3f(0, 1.2f, 0), 2), sphere(V3f(1.2f, 0.5f, 0.5f), 0.5f, 24, 4)});
  look(test, V3f(0.5f, 1.2f, 5), V3f(0, 0.6f, 0), 0.7f);
  test.whole = {std::move(scene), std::make_shared<Environment>(Rgb(0.2f, 0.25f, 0.3f))};
  test.parts = light_by_light(test.whole);
  test.traced_bounces = {0, 1};
  test.aims = {AimRectangle{V3f(-1.5f, 3, -1.5f), V3f(3, 0, 0), V3f(0, 0, 2)}};
  test.samples = 6;
  test.bias = [](IntegratorSettings& settings) { settings.clamp_direct = 0.5f; };
  return test;
}

TestScene kinds_of_lights() {
  TestScene test;
  const Material lamp = emissive_material(Rgb(4.0f, 3.0f, 2.0f));
  Scene scene = make_scene(
      {surface_material(Rgb(0.7f, 0.6f, 0.5f), 0.5f, 0.0f), diffuse_material(Rgb(0.5f, 0.6f, 0.7f)), lamp, lamp, lamp},
      {quad(V3f(-3, 0, 3), V3f(6, 0, 0), V3f(0, 0, -6), 0), quad(V3f(-3, 0, -3), V3f(6, 0, 0), V3f(0, 3, 0), 1),
       quad(V3f(-3, 0, -3), V3f(0, 0, 6), V3f(0, 3, 0), 1), quad(V3f(-1.5f, 2.5f, -1), V3f(1, 0, 0), V3f(0, 0, 1), 2),
       quad(V3f(0.8f, 2, -1.5f), V3f(0.8f, 0.3f, 0), V3f(0, 0, 0.8f), 3),
       quad(V3f(2.4f, 0.5f, -1), V3f(0, 0, 1), V3f(0, 1, 0), 4), sphere(V3f(0.2f, 0.6f, -0.8f), 0.6f, 24, 0)});
  PunctualLight point;
  point.intensity = 3.0f;
  point.range_m = 6.0f;
  place_light(scene, point, look_at(V3f(-1.2f, 1.6f, 0.8f), V3f(0.0f)));
  PunctualLight spot;
  spot.kind = PunctualLight::Kind::spot;
  spot.intensity = 12.0f;
  spot.inner_cone_rad = 0.3f;
  spot.outer_cone_rad = 0.6f;
  place_light(scene, spot, look_at(V3f(1.5f, 2.6f, 1.5f), V3f(0.5f, 0, -0.5f)));
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 1.0f;
  place_light(scene, sun, look_at(V3f(2, 4, 3), V3f(0.0f)));
  look(test, V3f(1.2f, 1.5f, 4.5f), V3f(-0.5f, 0.5f, -1), 0.6f);
  test.whole = {std::move(scene), std::make_shared<Environment>(Rgb(0.2f, 0.25f, 0.3f))};
  test.parts = light_by_light(test.whole);
  test.samples = 5;
  test.bias = [](IntegratorSettings& settings) { settings.clamp_direct = 0.9f; };
  return test;
}

// All transmissive and layered materials. Glass is rough, so that the plain tracer finds the lamp
// through it.
TestScene layered_materials() {
  TestScene test;
  std::vector<Material> materials{surface_material(Rgb(0.6f, 0.5f, 0.4f), 0.6f, 0.0f),
                                  emissive_material(Rgb(6.0f, 5.0f, 4.0f), Rgb(0.3f))};
  const auto add = [&](const Rgb& color, float roughness, float metallic) -> Material& {
    materials.push_back(surface_material(color, roughness, metallic));
    return materials.back();
  };
  Material& coated = add(Rgb(0.7f, 0.1f, 0.1f), 0.6f, 0.0f); // 2
  coated.clearcoat_factor = 0.8f;
  coated.clearcoat_roughness_factor = 0.3f;
  Material& cloth = add(Rgb(0.1f, 0.2f, 0.5f), 0.9f, 0.0f); // 3
  cloth.sheen_color_factor = Rgb(0.9f, 0.8f, 0.7f);
  cloth.sheen_roughness_factor = 0.4f;
  Material& film = add(Rgb(0.9f), 0.3f, 0.5f); // 4
  film.iridescence_factor = 1.0f;
  Material& leaf = add(Rgb(0.5f, 0.7f, 0.3f), 0.5f, 0.0f); // 5
  leaf.diffuse_transmission_factor = 0.6f;
  leaf.diffuse_transmission_color_factor = Rgb(0.6f, 0.9f, 0.2f);
  Material& frosted = add(Rgb(0.9f, 0.95f, 1.0f), 0.5f, 0.0f); // 6
  frosted.transmission_factor = 0.8f;
  Material& window = add(Rgb(0.5f, 0.8f, 0.9f), 0.0f, 0.0f); // 7
  window.transmission_factor = 1.0f;
  Material& half_window = add(Rgb(0.9f, 0.6f, 0.5f), 0.0f, 0.3f); // 8: reflects diffusely, too, and has holes
  half_window.transmission_factor = 0.6f;
  half_window.alpha_mode = AlphaMode::blend;
  half_window.base_color_factor.w = 0.7f;
  Material& solid = add(Rgb(1.0f), 0.4f, 0.0f); // 9
  solid.transmission_factor = 1.0f;
  solid.thickness_factor = 1.0f;
  solid.attenuation_color = Rgb(0.4f, 0.8f, 0.6f);
  solid.attenuation_distance_m = 0.5f;
  test.whole = {
      make_scene(std::move(materials),
                 {quad(V3f(-4, 0, 3), V3f(8, 0, 0), V3f(0, 0, -6), 0),
                  quad(V3f(-1, 2.6f, -1.5f), V3f(2, 0, 0), V3f(0, 0, 1), 1), sphere(V3f(-2, 0.5f, -0.5f), 0.5f, 16, 2),
                  sphere(V3f(-0.9f, 0.4f, -0.9f), 0.4f, 16, 3), sphere(V3f(0.1f, 0.4f, -0.4f), 0.4f, 16, 4),
                  quad(V3f(0.5f, 0, 0.6f), V3f(0.7f, 0, -0.3f), V3f(0.2f, 0.9f, 0), 5),
                  quad(V3f(-1.6f, 0, 0.7f), V3f(0.9f, 0, 0.1f), V3f(0, 0.8f, -0.2f), 6),
                  quad(V3f(-2, 1.6f, 1), V3f(2.4f, 0, 0), V3f(0, 0, -2.5f), 7),
                  quad(V3f(0.3f, 1.4f, 1), V3f(2.4f, 0, 0), V3f(0, 0.3f, -2.5f), 8),
                  sphere(V3f(1.5f, 0.5f, -0.2f), 0.5f, 24, 9)}),
      std::make_shared<Environment>(Rgb(0.25f, 0.3f, 0.4f))};
  look(test, V3f(0.2f, 1.3f, 4.2f), V3f(0, 0.6f, 0), 0.8f);
  test.max_bounces = 2;
  test.traced_bounces = {2};
  test.traced_samples = 96;
  test.samples = 14;
  test.aims = {AimRectangle{V3f(-1, 2.6f, -1.5f), V3f(2, 0, 0), V3f(0, 0, 1)}};
  test.bias = [](IntegratorSettings& settings) { settings.clamp_indirect = 0.25f; };
  return test;
}

TestScene cornell_box() {
  TestScene test = shipped("cornell_box.glb");
  look(test, V3f(0, 3, 2.7f), V3f(0, 0.8f, -1.5f), 0.9f); // below the lamp: its edges are noise
  test.size_px = V2i(24, 24);
  test.max_bounces = 4;
  test.traced_bounces = {4};
  test.aims = {AimRectangle{V3f(-0.65f, 5.483f, -0.524f), V3f(1.3f, 0, 0), V3f(0, 0, 1.05f)}};
  test.traced_samples = 75;
  test.samples = 7;
  test.bias = [](IntegratorSettings& settings) { settings.clamp_indirect = 0.2f; };
  return test;
}

// Metals and dielectrics of all roughnesses from 0 to 1.
TestScene material_grid() {
  TestScene test = shipped("material_grid.glb");
  const auto sky = float_image(32, 16, [](int x, int y) {
    if (x >= 20 && x < 23 && y >= 3 && y < 6) return Rgb(2.0f, 1.7f, 1.4f);
    return Rgb(0.6f, 0.8f, 1.0f) * (y < 8 ? 1.0f : 0.5f);
  });
  test.whole.environment = std::make_shared<Environment>(sky, 0.0f, 1.0f);
  test.traced_bounces = {1};
  const float phi = 2.0f * kPi * (21.5f / 32.0f - 0.5f), theta = kPi * 4.5f / 16.0f;
  test.aims = {AimCone{V3f(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)), 0.1f}};
  test.traced_samples = 58;
  test.samples = 9;
  test.bias = [](IntegratorSettings& settings) { settings.clamp_direct = 0.8f; };
  return test;
}

// Direct light alone: caustics of the sun would make the variance of more bounces too large for a
// test. The view excludes the window, where faces of two objects are coplanar and accelerators may
// report either.
TestScene interior() {
  TestScene test = shipped("interior.glb");
  const Camera camera(test.camera, test.camera_to_world, V2i(320, 240));
  const V3f eye = camera.position();
  look(test, eye, eye + camera.generate_ray(V2f(165, 200), V2f(0.5f), 0.0f).direction,
       0.12f); // the rug, where the sun is
  test.max_bounces = 0;
  test.parts = {{test.whole.scene, nullptr}, {test.whole.scene, nullptr}};
  for (Material& material : test.parts[0].scene.materials) material.emissive_factor = Rgb(0.0f);
  for (PunctualLight& light : test.parts[1].scene.lights) light.intensity = 0.0f;
  test.samples = 13;
  test.bias = [](IntegratorSettings& settings) { settings.clamp_direct = 1.2f; };
  return test;
}

} // namespace kindling::test
