// A pilot chooses light paths where they pay off; all runs, parts and threads choose the same.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/choose_light_paths.h"
#include "tests/integrator/place_light.h"
#include "tests/session/pilot_renders.h"

#include <string>
#include <vector>

namespace kindling::test {
namespace {

RenderSettings open_settings(uint32_t samples = 5) {
  RenderSettings settings = long_render(samples);
  settings.chooses_light_paths = true;
  return settings;
}

std::string refusal_to_resume(const World& world, const RenderSettings& settings, RenderContinuity continuity) {
  const Result<RenderOutcome> outcome =
      render(world, glass_camera(kPilotSize), settings, nullptr, nullptr, std::move(continuity));
  return outcome.ok() ? std::string() : outcome.error().message;
}

TEST(ChooseLightPaths, ChoosesThemWhereLightComesThroughGlass) {
  const auto world = glass_world(accel::Kind::kdtree);
  const RenderOutcome outcome = render_open(*world, open_settings());
  const LightPathChoice& choice = outcome.statistics.light_paths;
  EXPECT_GT(choice.fraction, 0.0f);
  EXPECT_LT(choice.predicted, 1.0 / kMinLightPathGain);
  EXPECT_GT(choice.camera_paths, 0U);
  EXPECT_GT(choice.light_paths, 0U);
  EXPECT_EQ(choice.why_none, "");
  EXPECT_TRUE(outcome.film.has_splats());
  EXPECT_EQ(outcome.work.light_paths, choice.fraction);
  RenderSettings fixed = open_settings();
  fixed.chooses_light_paths = false;
  fixed.integrator.light_paths = choice.fraction;
  expect_same_bits(outcome.film, render_open(*world, fixed).film, "the chosen fraction");
  // A fraction that is given is taken.
  fixed.chooses_light_paths = true;
  fixed.integrator.light_paths = 1.0f;
  EXPECT_EQ(render_open(*world, fixed).statistics.light_paths.fraction, 1.0f);
  EXPECT_EQ(render_open(*world, fixed).statistics.light_paths.camera_paths, 0U);
}

// A sphere of rough metal under a sun: paths from the camera find its reflections, too, with noise.
std::unique_ptr<const World> metal_world() {
  Material metal = diffuse_material(Rgb(0.9f));
  metal.metallic_factor = 1.0f;
  metal.roughness_factor = 0.2f;
  Scene scene = make_scene({diffuse_material(Rgb(0.6f)), metal},
                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 48, 1)});
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 5.0f;
  place_light(scene, sun, look_at(V3f(2, 5, 3), V3f(0.0f)));
  return make_world(std::move(scene), accel::Kind::kdtree);
}

TEST(ChooseLightPaths, LessNoiseWithThem) {
  const auto world = metal_world();
  const auto noise_at = [&](float fraction) {
    RenderSettings settings = long_render(32);
    settings.integrator.light_paths = fraction;
    return relative_noise(*world, settings, 0.01);
  };
  RenderSettings settings = open_settings();
  settings.planned_samples = 4096; // a pilot that sees enough
  const LightPathChoice choice = choose_light_paths(*world, glass_camera(kPilotSize), settings, nullptr, {}, nullptr);
  ASSERT_GT(choice.fraction, 0.0f);
  EXPECT_LT(noise_at(choice.fraction), 0.85 * noise_at(0.0f));
}

TEST(ChooseLightPaths, CostNothingWithoutCasters) {
  Scene scene = make_scene(
      {diffuse_material(Rgb(0.7f)), emissive_material(Rgb(5.0f))},
      {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), quad(V3f(-0.5f, 5, -0.5f), V3f(1, 0, 0), V3f(0, 0, 1), 1)});
  const auto plain = make_world(std::move(scene), accel::Kind::kdtree);
  RenderSettings settings = open_settings();
  const RenderOutcome outcome = render_open(*plain, settings);
  EXPECT_EQ(outcome.statistics.light_paths.fraction, 0.0f);
  EXPECT_EQ(outcome.statistics.light_paths.camera_paths, 0U);
  EXPECT_EQ(outcome.statistics.light_paths.rays.total(), 0U);
  EXPECT_NE(outcome.statistics.light_paths.why_none.find("no light reaches glass, metal or a coat"), std::string::npos);
  EXPECT_FALSE(outcome.film.has_splats());
  settings.chooses_light_paths = false;
  expect_same_bits(outcome.film, render_open(*plain, settings).film, "no casters");
}

TEST(ChooseLightPaths, ShortRendersHaveNoPilot) {
  RenderSettings settings = open_settings();
  EXPECT_EQ(pilot_paths(settings), 40U * 30U * 1024U / 64U);
  settings.planned_samples = 512;
  EXPECT_EQ(pilot_paths(settings), 0U);
  settings.planned_samples = 1U << 20;
  EXPECT_EQ(pilot_paths(settings), 65536U);
  settings.time_limit_s = 5.0;
  EXPECT_EQ(pilot_paths(settings), 20480U);
  settings.time_limit_s = 2.0;
  EXPECT_EQ(pilot_paths(settings), 0U);
  const auto world = glass_world(accel::Kind::kdtree);
  settings = open_settings();
  settings.planned_samples = 16;
  const RenderOutcome outcome = render_open(*world, settings);
  EXPECT_EQ(outcome.statistics.light_paths.camera_paths, 0U);
  EXPECT_NE(outcome.statistics.light_paths.why_none.find("too short for a pilot"), std::string::npos);
  EXPECT_FALSE(outcome.film.has_splats());
}

// A lamp without a size behind smooth glass: no path from the camera finds it.
TEST(ChooseLightPaths, SeesLightThatOnlyTheyFind) {
  Material glass = diffuse_material(Rgb(1.0f));
  glass.roughness_factor = 0.0f;
  glass.specular_factor = glass.transmission_factor = glass.thickness_factor = 1.0f;
  Scene scene = make_scene({diffuse_material(Rgb(0.7f)), glass},
                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 32, 1)});
  PunctualLight lamp;
  lamp.intensity = 20.0f;
  place_light(scene, lamp, look_at(V3f(0.5f, 6, 0.5f), V3f(0.0f)));
  const auto world = make_world(std::move(scene), accel::Kind::kdtree);
  EXPECT_GT(choose_light_paths(*world, glass_camera(kPilotSize), open_settings(), nullptr, {}, nullptr).fraction, 0.0f);
}

TEST(ChooseLightPaths, DoNotDependOnThreadsSamplesAndRegions) {
  const auto world = glass_world(accel::Kind::kdtree);
  const LightPathChoice expected = render_open(*world, open_settings()).statistics.light_paths;
  const auto expect_same_choice = [&](const RenderSettings& settings, const char* what) {
    const LightPathChoice choice = render_open(*world, settings).statistics.light_paths;
    EXPECT_EQ(choice.fraction, expected.fraction) << what;
    EXPECT_EQ(choice.predicted, expected.predicted) << what;
    EXPECT_EQ(choice.rays.total(), expected.rays.total()) << what;
  };
  RenderSettings settings = open_settings();
  settings.threads = 3;
  settings.tile_size_px = 8;
  expect_same_choice(settings, "threads");
  settings.region = PixelRect{V2i(8, 8), V2i(24, 16)};
  settings.samples = SampleRange{2, 3};
  expect_same_choice(settings, "a part");
}

TEST(ChooseLightPaths, ResumedRendersKeepTheChoice) {
  const auto world = glass_world(accel::Kind::kdtree);
  const Film whole = render_open(*world, open_settings(9)).film;
  std::optional<RenderState> saved;
  (void)render_open(*world, open_settings(4), {.save = [&](const RenderState& state) { saved = state; }});
  ASSERT_TRUE(saved);
  ASSERT_GT(saved->work.light_paths.value_or(0.0f), 0.0f);
  RenderSettings longer = open_settings(9);
  longer.time_limit_s = 1000.0; // another pilot would choose
  const RenderOutcome outcome = render_open(*world, longer, {.resume_from = saved});
  EXPECT_EQ(outcome.statistics.light_paths.camera_paths, 0U);
  EXPECT_EQ(outcome.statistics.light_paths.fraction, *saved->work.light_paths);
  expect_same_bits(outcome.film, whole, "a resumed render");
  // A device takes over; a render without them cannot.
  RenderSettings other = open_settings(9);
  other.device = DeviceKind::host;
  expect_same_bits(render_open(*world, other, {.resume_from = saved}).film, whole, "resumed by a device");
  other = open_settings(9);
  other.chooses_light_paths = false;
  EXPECT_NE(refusal_to_resume(*world, other, {.resume_from = saved}).find("the state was rendered with light paths"),
            std::string::npos);
}

// A render that was stopped before its first sample has chosen nothing.
TEST(ChooseLightPaths, StoppedPilotsChooseLater) {
  const auto world = glass_world(accel::Kind::kdtree);
  CancelToken token;
  token.cancel_now();
  const RenderOutcome stopped = render_open(*world, open_settings(), {}, &token);
  EXPECT_EQ(stopped.statistics.light_paths.fraction, 0.0f);
  RenderState state{
      Film(kPilotSize, {V2i(0), kPilotSize}, open_settings().aovs), Coverage({V2i(0), kPilotSize}), {}, stopped.work};
  const RenderOutcome outcome = render_open(*world, open_settings(), {.resume_from = std::move(state)});
  EXPECT_GT(outcome.statistics.light_paths.fraction, 0.0f);
  expect_same_bits(outcome.film, render_open(*world, open_settings()).film, "a render that began again");
}

TEST(ChooseLightPaths, AreOffBesideOtherSettings) {
  const auto expect_none = [](const char* words, void (*change)(RenderSettings&)) {
    expect_no_choice(open_settings(2), &RenderSettings::chooses_light_paths, &RenderStatistics::light_paths,
                     &LightPathChoice::camera_paths, words, change);
  };
  expect_none("not with --clamp-indirect", [](RenderSettings& s) { s.integrator.clamp_indirect = 1.0f; });
  expect_none("with --outliers trim", [](RenderSettings& s) { s.outliers = Outliers::trim; });
  expect_none("not with --photons", [](RenderSettings& s) { s.integrator.photons = 0.1f; });
  expect_none("not with --noise-threshold", [](RenderSettings& s) {
    s.adaptive.noise_threshold = 0.1;
    s.aovs.insert(Aov::samples);
  });
}

TEST(ChooseLightPaths, CropsHaveThePixelsOfTheWholeImage) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = open_settings();
  const RenderOutcome whole = render_open(*world, settings);
  ASSERT_GT(whole.statistics.light_paths.fraction, 0.0f);
  settings.crop = PixelRect{V2i(5, 3), V2i(30, 28)};
  const RenderOutcome crop = render_open(*world, settings);
  EXPECT_EQ(crop.statistics.light_paths.predicted, whole.statistics.light_paths.predicted);
  expect_same_bits(crop.film, whole.film, "a crop");
}

TEST(ChooseLightPaths, DevicesHaveTheChoiceOfTheCpu) {
  const auto world = glass_world(accel::Kind::kdtree);
  const RenderOutcome expected = render_open(*world, open_settings(2));
  ASSERT_GT(expected.statistics.light_paths.fraction, 0.0f);
  for (const DeviceKind device : {DeviceKind::host, DeviceKind::automatic}) {
    RenderSettings settings = open_settings(2);
    settings.device = device;
    const RenderOutcome found = render_open(*world, settings);
    EXPECT_EQ(found.statistics.light_paths.fraction, expected.statistics.light_paths.fraction);
    EXPECT_EQ(found.work.light_paths, expected.work.light_paths);
    expect_same_bits(found.film, expected.film, std::string(device_kind_name(device)));
  }
}

// A replayed sample is that of the render: without the light that light paths bring.
TEST(ChooseLightPaths, ReplaysHaveTheirWeights) {
  const auto world = metal_world();
  RenderSettings open = open_settings();
  open.planned_samples = 4096;
  RenderSettings fixed = open;
  fixed.chooses_light_paths = false;
  LearnedPaths learned;
  const RenderOutcome outcome =
      render_open(*world, open, {.after_training = [&](const LearnedPaths& by_render) { learned = by_render; }});
  EXPECT_EQ(learned.light_paths, outcome.statistics.light_paths.fraction);
  fixed.integrator.light_paths = learned.light_paths;
  const auto replayed = [&](const RenderSettings& settings, const V2i& pixel) {
    return replay_sample(*world, glass_camera(kPilotSize), settings, pixel, 1).value().radiance;
  };
  bool differ = false;
  for (int x = 0; x < kPilotSize.x; ++x)
    for (const int y : {18, 22, 26}) {
      const auto with = [&](const LearnedPaths& paths) {
        return replay_sample(*world, glass_camera(kPilotSize), open, paths, V2i(x, y), 1).value().radiance;
      };
      const Rgb found = with(learned);
      differ |= !(found == with({learned.guide, 0.0f}));
      if (x % 16 == 8) {
        EXPECT_EQ(found, replayed(open, V2i(x, y)));
        EXPECT_EQ(found, replayed(fixed, V2i(x, y)));
      }
    }
  EXPECT_TRUE(differ);
}

} // namespace
} // namespace kindling::test
