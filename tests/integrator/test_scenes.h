// Builders of small scenes in memory, and renders of a few of their pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/place_camera.h"
#include "renderer/session/render_session.h"
#include "renderer/world/build_world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace kindling::test {

// A Lambertian material, without specular reflection.
inline Material diffuse_material(const Rgb& albedo) {
  Material material;
  material.base_color_factor = V4f(albedo.x, albedo.y, albedo.z, 1.0f);
  material.metallic_factor = 0.0f;
  material.specular_factor = 0.0f;
  material.double_sided = true;
  return material;
}

inline Material metal_material(const Rgb& color, float roughness) {
  Material material = diffuse_material(color);
  material.metallic_factor = 1.0f;
  material.roughness_factor = roughness;
  return material;
}

// A dielectric over a diffuse base.
inline Material glossy_material(const Rgb& color, float roughness) {
  Material material = diffuse_material(color);
  material.specular_factor = 1.0f;
  material.roughness_factor = roughness;
  return material;
}

// Solid glass.
inline Material glass_material(float roughness) {
  Material material = glossy_material(Rgb(1.0f), roughness);
  material.transmission_factor = 1.0f;
  material.thickness_factor = 1.0f;
  return material;
}

inline Material emissive_material(const Rgb& radiance, const Rgb& albedo = Rgb(0.0f)) {
  Material material = diffuse_material(albedo);
  material.emissive_factor = radiance;
  return material;
}

// A parallelogram, counter-clockwise as seen from the side that its normal points to.
inline Primitive quad(const V3f& corner, const V3f& edge_u, const V3f& edge_v, int material) {
  Primitive primitive;
  primitive.material = material;
  primitive.positions = {corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v};
  primitive.indices = {0, 1, 2, 0, 2, 3};
  primitive.texcoords = {{V2f(0, 0), V2f(1, 0), V2f(1, 1), V2f(0, 1)}};
  return primitive;
}

// A closed sphere of latitude and longitude patches with smooth normals; front faces outside.
inline Primitive sphere(const V3f& center, float radius, int slices, int material, bool smooth = true) {
  Primitive primitive;
  primitive.material = material;
  const int stacks = slices / 2;
  for (int i = 0; i <= stacks; ++i)
    for (int j = 0; j < slices; ++j) {
      const float theta = kPi * static_cast<float>(i) / static_cast<float>(stacks);
      const float phi = 2.0f * kPi * static_cast<float>(j) / static_cast<float>(slices);
      const V3f n(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
      primitive.positions.push_back(center + n * radius);
      if (smooth) primitive.normals.push_back(n);
    }
  const auto at = [slices](int i, int j) { return static_cast<uint32_t>(i * slices + j % slices); };
  for (int i = 0; i < stacks; ++i)
    for (int j = 0; j < slices; ++j) {
      for (const uint32_t index : {at(i, j), at(i + 1, j), at(i + 1, j + 1)}) primitive.indices.push_back(index);
      for (const uint32_t index : {at(i, j), at(i + 1, j + 1), at(i, j + 1)}) primitive.indices.push_back(index);
    }
  return primitive;
}

// A scene with one node and one mesh for each primitive.
inline Scene make_scene(std::vector<Material> materials, std::vector<Primitive> primitives) {
  Scene scene;
  scene.source = "test";
  scene.materials = std::move(materials);
  SceneRoot root;
  for (Primitive& primitive : primitives) {
    Mesh mesh;
    mesh.primitives.push_back(std::move(primitive));
    Node node;
    node.mesh = static_cast<int>(scene.meshes.size());
    root.nodes.push_back(static_cast<int>(scene.nodes.size()));
    scene.meshes.push_back(std::move(mesh));
    scene.nodes.push_back(std::move(node));
  }
  scene.scenes.push_back(root);
  return scene;
}

// Adds a material, and a primitive with it in a mesh and node of its own.
inline void add_object(Scene& scene, const Material& material, Primitive primitive) {
  primitive.material = static_cast<int>(scene.materials.size());
  scene.materials.push_back(material);
  Node node;
  node.mesh = static_cast<int>(scene.meshes.size());
  scene.meshes.push_back({.primitives = {std::move(primitive)}});
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
}

// A glossy sphere on a floor, below a lamp, a half transparent veil beside it.
inline Scene sphere_lamp_and_veil(float sphere_roughness) {
  Material glossy;
  glossy.base_color_factor = V4f(0.9f, 0.6f, 0.3f, 1.0f);
  glossy.roughness_factor = sphere_roughness;
  Material veil = diffuse_material(Rgb(0.2f, 0.4f, 0.8f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.5f;
  return make_scene({glossy, diffuse_material(Rgb(0.7f)), emissive_material(Rgb(5.0f, 4.0f, 3.0f)), veil},
                    {sphere(V3f(0.0f), 1.0f, 32, 0), quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 1),
                     quad(V3f(-1, 3, -1), V3f(2, 0, 0), V3f(0, 0, 2), 2),
                     quad(V3f(1, -1, 1), V3f(2, 0, 0), V3f(0, 2, 0), 3)});
}

inline std::unique_ptr<const World> make_world(Scene scene, accel::Kind kind,
                                               std::shared_ptr<const Environment> environment = nullptr) {
  Result<PosedScene> posed = pose_scene(scene, {});
  EXPECT_TRUE(posed.ok());
  WorldOptions options;
  options.accelerator = kind;
  options.environment = std::move(environment);
  options.studio = Studio::off;
  Result<std::unique_ptr<const World>> world =
      build_world(std::move(scene), std::move(posed).value(), options, nullptr, nullptr);
  EXPECT_TRUE(world.ok());
  return std::move(world).value();
}

inline M44f look_at(const V3f& eye, const V3f& target) { return kindling::look_at(eye, target, V3f(0, 1, 0)); }

// An orthographic camera that sees a square of side `side_m`.
inline Camera beam_camera(const V3f& eye, const V3f& target, float side_m, const V2i& size_px = {8, 8}) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = side_m * 0.5f;
  return {camera, look_at(eye, target), size_px};
}

inline RenderSettings small_render(const V2i& size_px, uint32_t spp) {
  RenderSettings settings;
  settings.size_px = size_px;
  settings.samples_per_pixel = spp;
  settings.threads = 2;
  settings.aovs.insert(Aov::variance);
  settings.integrator.roulette_start_bounce = 1000;
  return settings;
}

struct Mean {
  Rgb rgb{0.0f};
  double luminance = 0.0;
  double standard_error = 0.0; // of the luminance
};

// Returns the mean over all pixels, with the standard error from the pixels' own variances. That of
// Owen-scrambled samples is lower.
inline Mean mean_of(const Film& film) {
  Mean mean;
  const std::vector<float> beauty = film.resolve(Aov::beauty);
  const std::vector<float> variance = film.resolve(Aov::variance);
  double sum[3] = {0, 0, 0}, variance_sum = 0;
  for (size_t i = 0; i < variance.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) sum[c] += beauty[i * 3 + c];
    variance_sum += variance[i];
  }
  const auto n = static_cast<double>(variance.size());
  mean.rgb = Rgb(static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n), static_cast<float>(sum[2] / n));
  mean.luminance = luminance(mean.rgb);
  mean.standard_error = std::sqrt(variance_sum) / n;
  return mean;
}

inline Mean render_mean(const World& world, const Camera& camera, const RenderSettings& settings) {
  const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.value().statistics.rays.non_finite, 0U);
  return mean_of(outcome.value().film);
}

inline constexpr accel::Kind kAllKinds[] = {accel::Kind::brute_force, accel::Kind::embree, accel::Kind::kdtree};

} // namespace kindling::test
