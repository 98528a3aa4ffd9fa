// Surfaces that are shaded eight at a time give paths the bits of surfaces that are shaded alone.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/guide.h"
#include "tests/integrator/slabs_of_media.h"
#include "tests/integrator/test_scenes.h"
#include "tests/light/light_fixtures.h"
#include "tests/session/same_bits.h"

namespace kindling::test {
namespace {

// Lambertian and glossy surfaces, mirrors and a coat in turn, so that every group of paths has some
// of each; a veil, a lamp that reflects, and lights without a size.
std::unique_ptr<const World> colorful_world() {
  Material plastic = glossy_material(Rgb(0.2f, 0.5f, 0.8f), 0.35f),
           half_metal = metal_material(Rgb(0.9f, 0.7f, 0.3f), 0.2f);
  half_metal.metallic_factor = 0.6f;
  Material coated = diffuse_material(Rgb(0.6f, 0.1f, 0.1f));
  coated.clearcoat_factor = 1.0f;
  Material veil = diffuse_material(Rgb(0.2f, 0.4f, 0.8f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.5f;
  const std::vector<Material> materials{diffuse_material(Rgb(0.7f)),
                                        plastic,
                                        half_metal,
                                        coated,
                                        metal_material(Rgb(0.9f), 0.05f),
                                        veil,
                                        emissive_material(Rgb(4.0f, 3.0f, 2.0f), Rgb(0.5f))};
  std::vector<Primitive> primitives{quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                    quad(V3f(-1, 3, -1), V3f(2, 0, 0), V3f(0, 0, 2), 6),
                                    quad(V3f(0, -1, 1.5f), V3f(1, 0, 0), V3f(0, 1.5f, 0), 5)};
  for (int i = 0; i < 25; ++i)
    primitives.push_back(
        sphere(V3f(-2.0f + static_cast<float>(i % 5), -0.6f, -2.0f + static_cast<float>(i / 5)), 0.45f, 16, i % 5));
  Scene scene = make_scene(materials, std::move(primitives));
  scene.lights.emplace_back();
  scene.nodes[0].light = 0;
  return make_world(std::move(scene), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.3f, 0.4f, 0.6f)));
}

// Glass in turn: clear, tinted, dispersive, under a film, rough, as a thin wall and partly covered;
// and mirrors.
std::unique_ptr<const World> world_of_glass() {
  Material prism = glass(1.6f), film = glass(1.3f), sheet = glass(1.5f), veiled = glass(1.4f);
  prism.dispersion = 2.0f;
  film.iridescence_factor = 1.0f;
  sheet.thickness_factor = 0.0f;
  veiled.alpha_mode = AlphaMode::blend;
  veiled.base_color_factor.w = 0.5f;
  Material tinted = absorbing(1.5f, Rgb(0.2f, 0.9f, 0.5f), 0.5f), rough = glass(1.5f);
  tinted.base_color_factor = V4f(0.9f, 0.7f, 0.5f, 1.0f);
  rough.roughness_factor = 0.3f;
  std::vector<Primitive> primitives{quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                    quad(V3f(-4, -1, -3), V3f(8, 0, 0), V3f(0, 4, 0), 8)};
  for (int i = 0; i < 25; ++i)
    primitives.push_back(
        sphere(V3f(-2.0f + static_cast<float>(i % 5), -0.4f, -2.0f + static_cast<float>(i / 5)), 0.55f, 16, 1 + i % 8));
  return make_world(
      make_scene({diffuse_material(Rgb(0.7f)), glass(1.5f), tinted, prism, film, rough, sheet, veiled,
                  metal_material(Rgb(0.9f), 0.05f)},
                 std::move(primitives)),
      accel::Kind::kdtree,
      std::make_shared<Environment>(
          float_image(16, 8, [](int x, int y) { return Rgb(x == 5 && y < 3 ? 60.0f : 0.5f); }), 0.0f, 1.0f));
}

// Rough glass in turn: narrow, wide, tinted, dispersive, and of an index that bends no light.
// Sheets of two kinds are open to the light behind them.
std::unique_ptr<const World> world_of_rough_glass() {
  const auto rough = [](float roughness, float ior) {
    Material material = glass(ior);
    material.roughness_factor = roughness;
    return material;
  };
  Material tinted = absorbing(1.5f, Rgb(0.2f, 0.9f, 0.5f), 0.5f), prism = rough(0.2f, 1.6f);
  tinted.roughness_factor = 0.4f;
  tinted.base_color_factor = V4f(0.9f, 0.7f, 0.5f, 1.0f);
  prism.dispersion = 2.0f;
  std::vector<Primitive> primitives{quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0),
                                    quad(V3f(-1, 3, -1), V3f(2, 0, 0), V3f(0, 0, 2), 6),
                                    quad(V3f(-1.5f, -1, 2), V3f(1.2f, 0, 0), V3f(0, 1.5f, 0), 3),
                                    quad(V3f(0.5f, -1, 2), V3f(1.2f, 0, 0), V3f(0, 1.5f, 0), 4)};
  for (int i = 0; i < 25; ++i)
    primitives.push_back(
        sphere(V3f(-2.0f + static_cast<float>(i % 5), -0.4f, -2.0f + static_cast<float>(i / 5)), 0.55f, 16, 1 + i % 5));
  return make_world(make_scene({diffuse_material(Rgb(0.7f)), rough(0.1f, 1.5f), rough(0.6f, 1.3f), tinted, prism,
                                rough(0.3f, 1.005f), emissive_material(Rgb(4.0f, 3.0f, 2.0f), Rgb(0.5f))},
                               std::move(primitives)),
                    accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.3f, 0.4f, 0.6f)));
}

// Opaque layers in turn: a coat on a Lambertian base and on plastic, sheen, brushed metal, all of
// them at once; beside them a film, paper that lets light through, and a coat that covers in part.
std::unique_ptr<const World> world_of_layers() {
  Material coated = diffuse_material(Rgb(0.6f, 0.1f, 0.1f)), lacquer = glossy_material(Rgb(0.2f, 0.5f, 0.8f), 0.35f);
  coated.clearcoat_factor = 1.0f;
  lacquer.clearcoat_factor = 0.7f;
  lacquer.clearcoat_roughness_factor = 0.3f;
  Material cloth = glossy_material(Rgb(0.3f, 0.2f, 0.4f), 0.8f), velvet = diffuse_material(Rgb(0.1f));
  cloth.sheen_color_factor = V3f(0.8f, 0.7f, 0.9f);
  cloth.sheen_roughness_factor = 0.2f;
  velvet.sheen_color_factor = V3f(0.9f, 0.2f, 0.2f);
  velvet.sheen_roughness_factor = 0.6f;
  Material brushed = metal_material(Rgb(0.9f, 0.7f, 0.3f), 0.2f);
  brushed.anisotropy_strength = 0.8f;
  brushed.anisotropy_rotation_rad = 0.6f;
  Material everything = brushed, film = brushed, paper = cloth, veil = lacquer;
  everything.metallic_factor = 0.4f;
  everything.clearcoat_factor = 0.5f;
  everything.sheen_color_factor = V3f(0.5f);
  everything.sheen_roughness_factor = 0.4f;
  film.iridescence_factor = 0.8f;
  paper.diffuse_transmission_factor = 0.5f;
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.5f;
  std::vector<Primitive> primitives{quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 2),
                                    quad(V3f(-1, 3, -1), V3f(2, 0, 0), V3f(0, 0, 2), 10),
                                    quad(V3f(0, -1, 1.5f), V3f(1, 0, 0), V3f(0, 1.5f, 0), 9)};
  for (int i = 0; i < 25; ++i) {
    primitives.push_back(
        sphere(V3f(-2.0f + static_cast<float>(i % 5), -0.6f, -2.0f + static_cast<float>(i / 5)), 0.45f, 16, 1 + i % 8));
    for (const V3f& n : primitives.back().normals) primitives.back().tangents.emplace_back(n.z, 0.0f, -n.x, 1.0f);
  }
  return make_world(make_scene({diffuse_material(Rgb(0.7f)), coated, lacquer, cloth, velvet, brushed, everything, film,
                                paper, veil, emissive_material(Rgb(4.0f, 3.0f, 2.0f), Rgb(0.5f))},
                               std::move(primitives)),
                    accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.3f, 0.4f, 0.6f)));
}

constexpr V2i kLanesImage(16, 8);
constexpr uint32_t kSamplesInLanes = 8;

struct Variant {
  IntegratorSettings settings;
  AovSet aovs;
  const Guide* guide = nullptr;
};

// `alone`: in batches of one sample of one pixel, whose surfaces have no company.
Film film_in_lanes(const World& world, const Variant& variant, bool alone) {
  const Camera camera(SceneCamera{}, look_at(V3f(1, 1.5f, 5), V3f(0, -0.5f, 0)), kLanesImage);
  const Sampler sampler(3);
  const PixelFilter filter;
  const auto integrator =
      make_integrator(variant.settings, world, camera, sampler, filter, variant.aovs, variant.guide);
  const auto context = integrator->make_context();
  Film film(kLanesImage, PixelRect{V2i(0), kLanesImage}, variant.aovs);
  if (!alone) {
    for (int x = 0; x < kLanesImage.x; x += 8)
      integrator->render_block({V2i(x, 0), V2i(x + 8, 8)}, {0, kSamplesInLanes}, *context, film);
    return film;
  }
  for (int y = 0; y < kLanesImage.y; ++y)
    for (int x = 0; x < kLanesImage.x; ++x)
      for (uint32_t sample = 0; sample < kSamplesInLanes; ++sample)
        integrator->render_block({V2i(x, y), V2i(x + 1, y + 1)}, {sample, sample + 1}, *context, film);
  return film;
}

void expect_alone_as_together(const World& world, const Variant& variant, const char* words) {
  expect_same_bits(film_in_lanes(world, variant, false), film_in_lanes(world, variant, true), words);
}
void expect_alone_as_together(const Variant& variant, const char* words) {
  expect_alone_as_together(*colorful_world(), variant, words);
}

// A patch above the scene.
Guide guide_to_lamp() {
  const BrightPatch above{V3f(0, 3, 0), V3f(1, 0, 1), 3, 10.0f};
  return {BrightPatches(std::span(&above, 1)), {}};
}

TEST(VertexLanes, OneLightSample) {
  expect_alone_as_together({}, "one light sample");
  Variant variant;
  variant.settings.roulette_start_bounce = 1;
  expect_alone_as_together(variant, "early roulette");
  for (const Aov aov : {Aov::albedo, Aov::normal, Aov::depth}) variant.aovs.insert(aov);
  expect_alone_as_together(variant, "AOVs");
  variant.settings.caustics = Caustics::regularized;
  expect_alone_as_together(variant, "regularized caustics");
}

TEST(VertexLanes, SeveralLightSamplesAndReflectionSamples) {
  for (const int lights : {1, 2, 5, kMaxDirectSamples})
    for (const int reflections : {0, 1, kMaxReflectionSamples}) {
      Variant variant;
      variant.settings.direct_samples = lights;
      variant.settings.reflection_samples = reflections;
      expect_alone_as_together(variant, "several samples");
    }
}

void expect_glass_alone_as_together(const World& world) {
  expect_alone_as_together(world, {}, "glass");
  Variant variant;
  variant.settings.roulette_start_bounce = 0;
  expect_alone_as_together(world, variant, "early roulette");
  variant.settings.direct_samples = 3;
  variant.settings.reflection_samples = 2;
  expect_alone_as_together(world, variant, "several samples");
  variant.settings.max_bounces = 3;
  expect_alone_as_together(world, variant, "few bounces");
  variant.settings.max_transmission_bounces = 2;
  expect_alone_as_together(world, variant, "few transmissions");
  for (const Aov aov : {Aov::albedo, Aov::normal, Aov::depth}) variant.aovs.insert(aov);
  expect_alone_as_together(world, variant, "AOVs");
  variant.settings.caustics = Caustics::regularized;
  expect_alone_as_together(world, variant, "regularized caustics");
}

TEST(VertexLanes, Glass) { expect_glass_alone_as_together(*world_of_glass()); }
TEST(VertexLanes, RoughGlass) { expect_glass_alone_as_together(*world_of_rough_glass()); }

// Mirrors, coats and glass cast caustics.
TEST(VertexLanes, CastersBesidePhotons) {
  const Guide guide = guide_to_lamp();
  for (const auto& make : {world_of_glass, world_of_rough_glass, world_of_layers, colorful_world}) {
    const auto world = make();
    for (const float light_paths : {0.0f, 0.5f}) {
      Variant variant;
      variant.settings.photons = 1.0f;
      variant.settings.light_paths = light_paths;
      expect_alone_as_together(*world, variant, "photons");
      variant.settings.direct_samples = 3;
      variant.settings.reflection_samples = 2;
      expect_alone_as_together(*world, variant, "photons beside several samples");
      variant.guide = &guide;
      expect_alone_as_together(*world, variant, "photons beside a guide");
    }
  }
}

TEST(VertexLanes, Layers) {
  const auto world = world_of_layers();
  const Guide guide = guide_to_lamp();
  for (const Guide* const found : {static_cast<const Guide*>(nullptr), &guide})
    for (const int samples : {1, 3}) {
      Variant variant;
      variant.guide = found;
      variant.settings.direct_samples = samples;
      variant.settings.reflection_samples = samples - 1;
      expect_alone_as_together(*world, variant, "layers");
      variant.settings.roulette_start_bounce = 0;
      expect_alone_as_together(*world, variant, "early roulette");
    }
  Variant variant;
  for (const Aov aov : {Aov::albedo, Aov::normal, Aov::depth}) variant.aovs.insert(aov);
  expect_alone_as_together(*world, variant, "AOVs");
  variant.settings.caustics = Caustics::regularized;
  expect_alone_as_together(*world, variant, "regularized caustics");
}

TEST(VertexLanes, GuidedToPatches) {
  const Guide guide = guide_to_lamp();
  for (const int lights : {1, 4}) {
    Variant variant;
    variant.guide = &guide;
    variant.settings.direct_samples = lights;
    variant.settings.reflection_samples = lights / 2;
    expect_alone_as_together(variant, "patches");
  }
}

// Paths whose light is split into passes are linked one by one.
TEST(VertexLanes, LinksBetweenPixels) {
  const Guide guide = guide_to_lamp();
  const auto world = colorful_world();
  for (const int paths : {1, 2, 4, 8}) {
    for (const Guide* const found : {static_cast<const Guide*>(nullptr), &guide}) {
      Variant variant;
      variant.settings.path_reuse = paths;
      variant.guide = found;
      const std::vector<float> together = film_in_lanes(*world, variant, false).resolve(Aov::beauty);
      for (const AovInfo& info : kAovs)
        if (is_light_pass(info.aov)) variant.aovs.insert(info.aov);
      EXPECT_TRUE(same_bits(together, film_in_lanes(*world, variant, false).resolve(Aov::beauty))) << paths;
    }
  }
}

} // namespace
} // namespace kindling::test
