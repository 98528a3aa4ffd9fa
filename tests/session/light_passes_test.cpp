// Light passes of renders: sums to the bit, and which event goes where.
// SPDX-License-Identifier: Apache-2.0
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"
#include "tests/session/split_film.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace kindling::test {
namespace {

const V2i kPassesSize(43, 29);

RenderSettings passes_render(uint32_t spp) {
  RenderSettings settings = small_render(kPassesSize, spp);
  for (const AovInfo& info : kAovs)
    if (is_light_pass(info.aov)) settings.aovs.insert(info.aov);
  return settings;
}

Film passes_of(const World& world, const RenderSettings& settings,
               const Camera& camera = {SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kPassesSize}) {
  RenderSettings fitting = settings;
  fitting.size_px = camera.size_px();
  Result<RenderOutcome> outcome = render(world, camera, fitting, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  return std::move(outcome).value().film;
}

TEST(LightPasses, SumToTheBeautyWhichIsUnchanged) {
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    const auto world = mixed_world(kind);
    for (const bool clamped : {false, true}) {
      RenderSettings settings = passes_render(16);
      RenderSettings plain = small_render(kPassesSize, 16);
      if (clamped)
        for (RenderSettings* s : {&settings, &plain}) s->integrator.clamp_direct = s->integrator.clamp_indirect = 0.5f;
      const Film film = passes_of(*world, settings);
      expect_sums_to_beauty(film, "light passes");
      expect_same_plane(film, passes_of(*world, plain), "beauty");
    }
  }
}

// The cloudy glass of the scene scatters in its medium; everything else occurs as well.
TEST(LightPasses, AllOccur) {
  const Film film = passes_of(*mixed_world(accel::Kind::kdtree), passes_render(16));
  // Nothing shines inside of media or is seen directly, and what glass transmits leaves it again.
  const std::set<Aov> none{Aov::volume_direct, Aov::transmission_direct, Aov::emit};
  for (const AovInfo& info : kAovs)
    if (is_light_pass(info.aov) && !none.contains(info.aov)) {
      EXPECT_GT(mean_luminance(film.resolve(info.aov)), 1e-4) << info.name;
    }
}

// Returns the names of the passes that have any light.
std::set<std::string_view> passes_with_light(const Film& film) {
  std::set<std::string_view> names;
  for (const AovInfo& info : kAovs) {
    if (!is_light_pass(info.aov) || info.aov >= Aov::diffuse_color) continue;
    const std::vector<float> values = film.resolve(info.aov);
    if (std::any_of(values.begin(), values.end(), [](float v) { return v != 0.0f; })) names.insert(info.name);
  }
  return names;
}

// A floor that fills the image, below an environment; nothing else.
std::set<std::string_view> passes_of_floor(const Material& material, bool lamp = false) {
  Scene scene =
      make_scene({material, emissive_material(Rgb(5.0f))}, {quad(V3f(-50, 0, 50), V3f(100, 0, 0), V3f(0, 0, -100), 0)});
  if (lamp)
    scene =
        make_scene({material, emissive_material(Rgb(5.0f))}, {quad(V3f(-50, 0, 50), V3f(100, 0, 0), V3f(0, 0, -100), 0),
                                                              quad(V3f(-1, 4, -1), V3f(2, 0, 0), V3f(0, 0, 2), 1)});
  const auto world =
      make_world(std::move(scene), accel::Kind::kdtree, lamp ? nullptr : std::make_shared<Environment>(Rgb(1.0f)));
  return passes_with_light(
      passes_of(*world, passes_render(4), beam_camera(V3f(0, 3, 0.01f), V3f(0.0f), 1.0f, kPassesSize)));
}

using Names = std::set<std::string_view>;

TEST(LightPasses, FollowTheFirstEvent) {
  const Material diffuse = diffuse_material(Rgb(0.8f));
  Material mirror;
  mirror.roughness_factor = 0.0f;
  Material glossy; // a metal
  glossy.roughness_factor = 0.4f;
  Material glass = diffuse;
  glass.specular_factor = 1.0f;
  glass.transmission_factor = glass.thickness_factor = 1.0f;
  EXPECT_EQ(passes_of_floor(diffuse), (Names{"diffuse_direct"}));
  EXPECT_EQ(passes_of_floor(diffuse, true), (Names{"diffuse_direct"})); // the lamp reflects nothing
  EXPECT_EQ(passes_of_floor(mirror), (Names{"glossy_direct"}));
  EXPECT_EQ(passes_of_floor(glossy), (Names{"glossy_direct"}));
  EXPECT_EQ(passes_of_floor(glossy, true), (Names{"glossy_direct"}));
  EXPECT_EQ(passes_of_floor(glass), (Names{"glossy_direct", "transmission_direct"}));
  Material shiny = diffuse;
  shiny.specular_factor = 1.0f;
  EXPECT_EQ(passes_of_floor(shiny), (Names{"diffuse_direct", "glossy_direct"}));
  EXPECT_EQ(passes_of_floor(emissive_material(Rgb(2.0f))), (Names{"emit"}));
  Material unlit = diffuse;
  unlit.unlit = true;
  EXPECT_EQ(passes_of_floor(unlit), (Names{"emit"}));
}

TEST(LightPasses, BackgroundsAreEnvironment) {
  const auto world =
      make_world(make_scene({diffuse_material(Rgb(0.5f))}, {quad(V3f(-50, 0, -40), V3f(100, 0, 0), V3f(0, 0, -1), 0)}),
                 accel::Kind::kdtree);
  RenderSettings settings = passes_render(2);
  settings.integrator.background = Rgb(0.25f, 0.5f, 1.0f);
  const Film film = passes_of(*world, settings, beam_camera(V3f(0, 3, 0.01f), V3f(0.0f), 1.0f, kPassesSize));
  EXPECT_EQ(passes_with_light(film), (Names{"environment"}));
  EXPECT_EQ(film.resolve(Aov::environment), film.resolve(Aov::beauty));
}

// Below a white environment the direct light of a convex body is its color.
TEST(LightPasses, ColorsAreTheAlbedosOfLobes) {
  Material shiny = diffuse_material(Rgb(0.8f, 0.4f, 0.2f));
  shiny.specular_factor = 1.0f;
  shiny.roughness_factor = 0.5f;
  shiny.clearcoat_factor = 0.5f;
  shiny.sheen_color_factor = Rgb(0.2f);
  shiny.sheen_roughness_factor = 0.5f;
  const auto world = make_world(make_scene({shiny}, {quad(V3f(-50, 0, 50), V3f(100, 0, 0), V3f(0, 0, -100), 0)}),
                                accel::Kind::kdtree, std::make_shared<Environment>(Rgb(1.0f)));
  RenderSettings settings = passes_render(256);
  settings.aovs.insert(Aov::albedo);
  const Film film = passes_of(*world, settings, beam_camera(V3f(2, 3, 0), V3f(0.0f), 1.0f, {8, 8}));
  const auto mean = [&](Aov aov, size_t c) {
    const std::vector<float> values = film.resolve(aov);
    double sum = 0.0;
    for (size_t i = c; i < values.size(); i += 3) sum += static_cast<double>(values[i]);
    return sum / (static_cast<double>(values.size()) / 3.0);
  };
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(mean(Aov::diffuse_direct, c), mean(Aov::diffuse_color, c), 0.01) << c;
    EXPECT_NEAR(mean(Aov::glossy_direct, c), mean(Aov::glossy_color, c), 0.01) << c;
    EXPECT_NEAR(mean(Aov::diffuse_color, c) + mean(Aov::glossy_color, c), mean(Aov::albedo, c), 1e-5) << c;
  }
  EXPECT_GT(mean(Aov::glossy_color, 0), 0.02);
}

TEST(LightPasses, AreRefusedByNameWhereLightIsNotSplit) {
  const auto world = mixed_world(accel::Kind::kdtree);
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kPassesSize);
  for (const IntegratorKind kind : all_integrators()) {
    if (kind == IntegratorKind::path) continue;
    RenderSettings settings = small_render(kPassesSize, 1);
    settings.aovs.insert(Aov::glossy_color);
    settings.integrator.kind = kind;
    const Result<RenderOutcome> outcome = render(*world, camera, settings, nullptr, nullptr);
    ASSERT_FALSE(outcome.ok());
    EXPECT_NE(outcome.error().message.find("--aov glossy_color: the integrator '"), std::string::npos)
        << outcome.error().message;
  }
}

} // namespace
} // namespace kindling::test
