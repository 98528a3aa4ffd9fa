// Light groups of renders: sums to the bit, and each group against a render of its light alone.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/accumulation_file.h"
#include "renderer/world/light_groups/light_groups.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"
#include "tests/session/split_film.h"

#include <cmath>
#include <filesystem>

namespace kindling::test {
namespace {

const V2i kSize(43, 29);

Camera camera() { return {SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSize}; }

void add_light(Scene& scene, PunctualLight light, const V3f& position) {
  Node node;
  node.name = light.name + " node";
  node.local.translation = position;
  node.light = static_cast<int>(scene.lights.size());
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  scene.lights.push_back(std::move(light));
}

// Everything that shines: the environment, a sun with an angle, a point and a sphere, a lamp, an
// unlit card, and a partly transparent emitter, which is not sampled.
Scene shining_scene() {
  Scene scene = mixed_scene();
  scene.materials[2].name = "lamp";
  PunctualLight sun{.name = "sun", .kind = PunctualLight::Kind::directional, .intensity = 2.0f};
  sun.angular_diameter_rad = 0.5f;
  add_light(scene, sun, V3f(0.0f));
  add_light(scene, {.name = "point", .intensity = 5.0f}, V3f(2, 2, 2));
  PunctualLight globe{.name = "globe", .color = Rgb(1.0f, 0.5f, 0.2f), .intensity = 8.0f};
  globe.radius_m = 0.3f;
  add_light(scene, globe, V3f(-2, 1, 2));
  Material card = diffuse_material(Rgb(0.2f, 0.9f, 0.4f));
  card.unlit = true;
  card.name = "card";
  add_object(scene, card, quad(V3f(1.5f, 0, -1), V3f(1, 0, 0), V3f(0, 1, 0), 0));
  Material glow = emissive_material(Rgb(0.5f, 0.5f, 3.0f));
  glow.name = "glow";
  glow.alpha_mode = AlphaMode::blend;
  glow.base_color_factor.w = 0.5f;
  add_object(scene, glow, quad(V3f(-3, 0, -1), V3f(1, 0, 0), V3f(0, 1, 0), 0));
  return scene;
}

std::unique_ptr<const World> shining_world(accel::Kind kind = accel::Kind::kdtree, Scene scene = shining_scene()) {
  return make_world(std::move(scene), kind, std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
}

RenderSettings split_render(LightGrouping grouping, uint32_t spp = 16) {
  RenderSettings settings = small_render(kSize, spp);
  settings.integrator.light_groups = grouping;
  return settings;
}

Film film_of(const World& world, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, camera(), settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  return std::move(outcome).value().film;
}

TEST(LightGroups, NamesOfEachGrouping) {
  const auto world = shining_world();
  const auto names = [&](LightGrouping grouping) { return make_light_groups(*world, grouping, false).value().names; };
  EXPECT_TRUE(names(LightGrouping::off).empty());
  EXPECT_EQ(names(LightGrouping::kind), (std::vector<std::string>{"environment", "suns", "lights", "emissive"}));
  EXPECT_EQ(names(LightGrouping::name),
            (std::vector<std::string>{"environment", "sun", "point", "globe", "lamp", "card", "glow"}));
  EXPECT_EQ(names(LightGrouping::extras), (std::vector<std::string>{"environment", "rest"}));
}

TEST(LightGroups, ExtrasOfNodesPrevailOverThoseOfLightsAndMaterials) {
  Scene scene = shining_scene();
  scene.lights[0].light_group = "key";
  scene.lights[1].light_group = "key";
  scene.nodes[static_cast<size_t>(scene.scenes[0].nodes.back()) - 2].light_group = "from.above"; // the globe's
  scene.materials[2].light_group = "practical";
  const auto world = shining_world(accel::Kind::kdtree, scene);
  const LightGroups groups = make_light_groups(*world, LightGrouping::extras, false).value();
  EXPECT_EQ(groups.names, (std::vector<std::string>{"environment", "key", "from_above", "practical", "rest"}));
  // A child inherits the group of its ancestor.
  Node parent;
  parent.light_group = "room";
  parent.children = {2}; // the lamp
  std::erase(scene.scenes[0].nodes, 2);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(parent);
  const auto nested = shining_world(accel::Kind::kdtree, scene);
  const LightGroups inherited = make_light_groups(*nested, LightGrouping::extras, false).value();
  EXPECT_EQ(inherited.names[inherited.view().of_surface(2, 2)], "room");
  EXPECT_EQ(inherited.names[inherited.view().of_surface(-1, 2)], "practical");
  EXPECT_EQ(inherited.names[inherited.of_emitter[0]], "room");
}

TEST(LightGroups, AreLimited) {
  Scene scene = shining_scene();
  for (int i = 0; i < 70; ++i) add_light(scene, {.name = "spot" + std::to_string(i)}, V3f(0, 2, 0));
  const auto world = shining_world(accel::Kind::kdtree, scene);
  const Result<LightGroups> groups = make_light_groups(*world, LightGrouping::name, false);
  ASSERT_FALSE(groups.ok());
  EXPECT_EQ(groups.error().kind, ErrorKind::usage);
  EXPECT_NE(groups.error().message.find("77 groups by name found; use at most 64"), std::string::npos)
      << groups.error().message;
  EXPECT_FALSE(render(*world, camera(), split_render(LightGrouping::name, 1), nullptr, nullptr).ok());
}

class SplitLightRenders : public testing::TestWithParam<accel::Kind> {};

TEST_P(SplitLightRenders, GroupsSumToTheBeautyWhichIsUnchanged) {
  const auto world = shining_world(GetParam());
  const Film plain = film_of(*world, small_render(kSize, 16));
  for (const LightGrouping grouping : {LightGrouping::kind, LightGrouping::name, LightGrouping::extras}) {
    const Film film = film_of(*world, split_render(grouping));
    expect_sums_to_beauty(film, "light groups");
    expect_same_plane(film, plain, "beauty");
    expect_same_plane(film, plain, "variance");
    for (size_t g = 0; g < film.light_groups().size(); ++g) // each has light
      EXPECT_GT(mean_luminance(film.resolve_light_group(g)), 1e-3) << film.light_groups()[g];
  }
}

TEST_P(SplitLightRenders, WithOtherOptions) {
  const auto world = shining_world(GetParam());
  const auto check = [&](const char* what, auto change) {
    RenderSettings settings = split_render(LightGrouping::name, 8);
    change(settings);
    const Film film = film_of(*world, settings);
    expect_sums_to_beauty(film, "light groups");
    settings.integrator.light_groups = LightGrouping::off;
    expect_same_plane(film, film_of(*world, settings), "beauty");
    settings.integrator.light_groups = LightGrouping::name;
    settings.threads = 5;
    settings.tile_size_px = 8;
    settings.integrator.batch_size = 64;
    expect_same_bits(film_of(*world, settings), film, what);
  };
  check("clamps", [](RenderSettings& s) { s.integrator.clamp_direct = s.integrator.clamp_indirect = 0.5f; });
  check("roulette", [](RenderSettings& s) { s.integrator.roulette_start_bounce = 0; });
  check("a background", [](RenderSettings& s) { s.integrator.background = Rgb(0.1f, 0.2f, 0.3f); });
  check("no background", [](RenderSettings& s) { s.integrator.transparent_background = true; });
  check("Mitchell's filter", [](RenderSettings& s) { s.filter = PixelFilter({.kind = FilterKind::mitchell}); });
  check("a guide", [](RenderSettings& s) {
    s.guiding = Guiding::on;
    s.planned_samples = 64;
  });
}
INSTANTIATE_TEST_SUITE_P(Accelerators, SplitLightRenders, testing::Values(accel::Kind::kdtree, accel::Kind::embree));

TEST(LightGroups, AreStoredInAccumulations) {
  const auto world = shining_world();
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("light_groups_" + std::to_string(getpid()) + ".kacc");
  std::optional<RenderState> saved;
  const Result<RenderOutcome> outcome = render(*world, camera(), split_render(LightGrouping::name, 4), nullptr, nullptr,
                                               {.save = [&](const RenderState& state) { saved = state; }});
  ASSERT_TRUE(outcome.ok());
  AccumulationIdentity identity;
  identity.size_px = kSize;
  identity.crop = {V2i(0), kSize};
  ASSERT_TRUE(write_accumulation(file, identity, *saved, false).ok());
  Result<Accumulation> read = read_accumulation(file);
  std::filesystem::remove(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().state.film.light_groups().size(), 7U);
  expect_same_bits(read.value().state.film, outcome.value().film, "a file");
  // Another way of grouping cannot resume from it.
  const Result<RenderOutcome> other =
      render(*world, camera(), split_render(LightGrouping::kind, 8), nullptr, nullptr, {.resume_from = *saved});
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.error().message.find("other light groups"), std::string::npos) << other.error().message;
}

TEST(LightGroups, AreRefusedByNameWhereLightIsNotSplit) {
  const auto world = shining_world();
  RenderSettings settings = split_render(LightGrouping::kind, 1);
  settings.integrator.kind = IntegratorKind::whitted;
  const Result<RenderOutcome> outcome = render(*world, camera(), settings, nullptr, nullptr);
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().kind, ErrorKind::usage);
  EXPECT_NE(outcome.error().message.find("--light-groups: the integrator 'whitted' does not split its light"),
            std::string::npos)
      << outcome.error().message;
}

// Means over the image of independent renders, whose spread gives the standard error.
struct Estimate {
  double mean = 0.0, error = 0.0;
};
template <typename Value>
Estimate estimate(const Value& value) {
  constexpr int kRuns = 12;
  double sum = 0.0, squares = 0.0;
  for (uint32_t seed = 0; seed < kRuns; ++seed) {
    const double x = value(seed);
    sum += x;
    squares += x * x;
  }
  const double mean = sum / kRuns;
  return {mean, std::sqrt(std::max(squares / kRuns - mean * mean, 0.0) / (kRuns - 1))};
}
void expect_equal(const Estimate& a, const Estimate& b, const std::string& what) {
  // Twelve runs estimate the error itself; 5 of these errors are beyond chance for ten comparisons.
  EXPECT_NEAR(a.mean, b.mean, 5.0 * std::hypot(a.error, b.error) + 1e-6) << what;
  EXPECT_GT(a.mean, 0.01) << what;
}

// Three lights of different kinds, with factors on them.
Scene three_lights(float lamp, float globe, float sun) {
  Scene scene = sphere_lamp_and_veil(0.3f);
  scene.materials[2].name = "lamp";
  scene.materials[2].emissive_factor = Rgb(5.0f, 4.0f, 3.0f) * lamp;
  PunctualLight sphere{.name = "globe", .intensity = 8.0f * globe};
  sphere.radius_m = 0.3f;
  add_light(scene, sphere, V3f(-2, 1, 2));
  PunctualLight disk{.name = "sun", .kind = PunctualLight::Kind::directional, .intensity = sun};
  disk.angular_diameter_rad = 0.3f;
  add_light(scene, disk, V3f(0.0f));
  return scene;
}

double group_mean(const Film& film, std::string_view name) {
  for (size_t g = 0; g < film.light_groups().size(); ++g)
    if (film.light_groups()[g] == name) return mean_luminance(film.resolve_light_group(g));
  return 0.0; // a light without power makes no group
}

TEST(LightGroups, EachIsTheRenderOfItsLightAlone) {
  const auto all = make_world(three_lights(1, 1, 1), accel::Kind::kdtree);
  RenderSettings settings = split_render(LightGrouping::name, 8);
  std::vector<Film> films;
  for (uint32_t seed = 0; seed < 12; ++seed) {
    settings.seed = seed;
    films.push_back(film_of(*all, settings));
  }
  struct Alone {
    const char* name;
    Scene scene;
  };
  for (Alone& alone : std::vector<Alone>{
           {"lamp", three_lights(1, 0, 0)}, {"globe", three_lights(0, 1, 0)}, {"sun", three_lights(0, 0, 1)}}) {
    const auto world = make_world(std::move(alone.scene), accel::Kind::kdtree);
    RenderSettings single = small_render(kSize, 8);
    const Estimate expected = estimate([&](uint32_t seed) {
      single.seed = 100 + seed;
      return mean_luminance(film_of(*world, single).resolve(Aov::beauty));
    });
    expect_equal(estimate([&](uint32_t seed) { return group_mean(films[seed], alone.name); }), expected, alone.name);
  }
}

TEST(LightGroups, MixedTheyAreTheRenderOfChangedLights) {
  const auto all = make_world(three_lights(1, 1, 1), accel::Kind::kdtree);
  const auto changed = make_world(three_lights(0.25f, 3, 1.5f), accel::Kind::kdtree);
  RenderSettings settings = split_render(LightGrouping::name, 8);
  const Estimate mixed = estimate([&](uint32_t seed) {
    settings.seed = seed;
    const Film film = film_of(*all, settings);
    return 0.25 * group_mean(film, "lamp") + 3.0 * group_mean(film, "globe") + 1.5 * group_mean(film, "sun");
  });
  RenderSettings plain = small_render(kSize, 8);
  const Estimate rendered = estimate([&](uint32_t seed) {
    plain.seed = 100 + seed;
    return mean_luminance(film_of(*changed, plain).resolve(Aov::beauty));
  });
  expect_equal(mixed, rendered, "mixed");
}

} // namespace
} // namespace kindling::test
