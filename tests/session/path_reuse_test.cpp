// Paths that are shared between pixels: less noise, the same bits however the work is divided.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"
#include "renderer/integrator/pilots/path_reuse_pilot.h"
#include "renderer/integrator/stages/reuse_paths.h"
#include "renderer/session/check_settings.h"
#include "tests/session/parts_of_light.h"
#include "tests/session/pilot_renders.h"

#include <set>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

// A white room with a red wall, which a lamp lights by way of its ceiling alone.
std::unique_ptr<const World> indirect_world() {
  return make_world(make_scene({diffuse_material(Rgb(0.8f)), diffuse_material(Rgb(0.8f, 0.1f, 0.1f)),
                                emissive_material(Rgb(20.0f), Rgb(0.5f))},
                               {quad(V3f(-4, 0, 8), V3f(8, 0, 0), V3f(0, 0, -12), 0),  // floor
                                quad(V3f(-4, 6, -4), V3f(8, 0, 0), V3f(0, 0, 12), 0),  // ceiling
                                quad(V3f(-4, 0, -4), V3f(8, 0, 0), V3f(0, 6, 0), 0),   // back
                                quad(V3f(-4, 0, 8), V3f(0, 0, -12), V3f(0, 6, 0), 1),  // left
                                quad(V3f(4, 0, -4), V3f(0, 0, 12), V3f(0, 6, 0), 0),   // right
                                quad(V3f(-1, 4.5f, 0), V3f(0, 0, 2), V3f(2, 0, 0), 2), // lamp, faces up
                                sphere(V3f(1, 1, 1), 1.0f, 24, 0)}),
                    accel::Kind::kdtree);
}

RenderSettings reusing(const V2i& size, uint32_t samples, int paths) {
  RenderSettings settings = small_render(size, samples);
  settings.integrator.path_reuse = paths;
  return settings;
}

// Each pixel is in one group, and all members of a group agree on it.
TEST(PathReuse, GroupsDivideABlock) {
  for (uint32_t pattern = 0; pattern < kReusePatterns; ++pattern)
    for (uint32_t pixel = 0; pixel < 64; ++pixel) {
      std::set<uint32_t> group;
      for (uint32_t place = 0; place < kMaxPathReuse; ++place) {
        const uint32_t partner = reuse_partner(pixel, pattern, place);
        EXPECT_LT(partner, 64U);
        EXPECT_EQ(reuse_partner(partner, pattern, place), pixel);
        group.insert(partner);
      }
      EXPECT_EQ(group.size(), kMaxPathReuse);
      for (const uint32_t member : group)
        for (uint32_t place = 0; place < kMaxPathReuse; ++place)
          EXPECT_TRUE(group.contains(reuse_partner(member, pattern, place)));
    }
}

// Indirect light is all the noise of this room: it falls almost like the inverse of the paths that
// are shared. Bounds leave a quarter for edges, and for the spread of eight seeds.
TEST(PathReuse, LowersTheNoiseOfIndirectLight) {
  const auto world = indirect_world();
  const auto noise = [&](int paths) { return relative_noise(*world, reusing(kPilotSize, 16, paths), 1e-3); };
  const double alone = noise(1);
  EXPECT_LT(noise(2), 0.8 * alone);
  EXPECT_LT(noise(4), 0.6 * alone);
  EXPECT_LT(noise(8), 0.45 * alone);
}

TEST(PathReuse, CropsHaveThePixelsOfTheWholeImage) {
  const auto world = mixed_world(accel::Kind::kdtree);
  const V2i size(43, 29); // blocks at two borders are cut
  RenderSettings settings = reusing(size, 5, 8);
  const Film whole = render_open(*world, settings).film;
  for (const PixelRect& crop : {PixelRect{V2i(5, 3), V2i(30, 27)}, PixelRect{V2i(41, 27), V2i(43, 29)}}) {
    settings.crop = crop;
    const RenderOutcome part = render_open(*world, settings);
    expect_same_bits(part.film, whole, "a crop");
    EXPECT_EQ(part.statistics.rays.paths, static_cast<uint64_t>(crop.pixel_count()) * 5);
  }
}

TEST(PathReuse, GroupsOfLightHaveTheSameMeans) {
  expect_same_parts([](RenderSettings& settings) { settings.integrator.path_reuse = 8; }, 0.0);
}

TEST(PathReuse, SplitLightSumsToTheBeautyWhichIsUnchanged) {
  const auto world = indirect_world();
  RenderSettings settings = reusing(kPilotSize, 5, 4);
  const std::vector<float> expected = render_open(*world, settings).film.resolve(Aov::beauty);
  divide_light(settings);
  const Film film = render_open(*world, settings).film;
  EXPECT_TRUE(same_bits(film.resolve(Aov::beauty), expected));
  std::vector<float> groups(expected.size());
  for (size_t group = 0; group < film.light_groups().size(); ++group) {
    const std::vector<float> light = film.resolve_light_group(group);
    for (size_t i = 0; i < groups.size(); ++i) groups[i] += light[i];
  }
  for (size_t i = 0; i < groups.size(); ++i) EXPECT_NEAR(groups[i], expected[i], 1e-6f * (1.0f + expected[i]));
}

TEST(PathReuse, SamplesAreReplayed) {
  const auto world = indirect_world();
  const RenderSettings settings = reusing(kPilotSize, 1, 8);
  const std::vector<float> image = render_open(*world, settings).film.resolve(Aov::beauty);
  for (const V2i& pixel : {V2i(20, 16), V2i(39, 29), V2i(0, 7)}) {
    const Result<ReplayedSample> sample = replay_sample(*world, glass_camera(kPilotSize), settings, pixel, 0);
    ASSERT_TRUE(sample.ok());
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_EQ(image[static_cast<size_t>((pixel.y * kPilotSize.x + pixel.x) * 3 + channel)],
                sample.value().radiance[channel]);
    ASSERT_FALSE(sample.value().trace.empty());
    EXPECT_EQ(sample.value().trace.front().event, "camera");
    EXPECT_EQ(sample.value().trace.back().event, kJoinedEvent);
  }
}

constexpr ChosenNumber kNumberOfPixels{&RenderSettings::chooses_path_reuse,
                                       [](const RenderStatistics& s) -> const SampleChoice& { return s.path_reuse; },
                                       [](const RenderStatistics& s) { return s.path_reuse.count; },
                                       &RenderWork::path_reuse, &IntegratorSettings::path_reuse};
RenderSettings long_reuse_to_choose() { return long_render_to_choose(kNumberOfPixels, 5); }

TEST(PathReuse, IsChosenForIndirectLight) {
  const auto world = indirect_world();
  const RenderOutcome outcome = render_open(*world, long_reuse_to_choose());
  const SampleChoice& choice = outcome.statistics.path_reuse;
  EXPECT_GE(choice.count, 4);
  EXPECT_LT(choice.predicted, 1.0 / kMinPathReuseGain);
  EXPECT_GT(choice.paths, 0U);
  expect_same_when_given(*world, kNumberOfPixels, outcome);
}

// The light samples are those that are best beside it.
TEST(PathReuse, IsChosenTogetherWithLightSamples) {
  const auto world = indirect_world();
  RenderSettings settings = long_reuse_to_choose();
  settings.chooses_direct_samples = settings.chooses_reflection_samples = true;
  const RenderOutcome outcome = render_open(*world, settings);
  const RenderStatistics& statistics = outcome.statistics;
  EXPECT_GE(statistics.path_reuse.count, 4);
  EXPECT_LT(statistics.path_reuse.predicted, 1.0 / kMinPathReuseGain);
  EXPECT_GT(statistics.direct_samples.paths, 0U);
  RenderSettings given = long_render(5);
  given.integrator.path_reuse = statistics.path_reuse.count;
  given.integrator.direct_samples = statistics.direct_samples.count;
  given.integrator.reflection_samples = statistics.direct_samples.reflections;
  expect_same_bits(outcome.film, render_open(*world, given).film, "the chosen numbers");
}

// Dark surfaces reflect hardly any light to each other.
std::unique_ptr<const World> dark_world() {
  return make_world(
      make_scene({diffuse_material(Rgb(0.05f)), emissive_material(Rgb(5.0f))},
                 {quad(V3f(-8, 0, 8), V3f(16, 0, 0), V3f(0, 0, -16), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 16, 0),
                  quad(V3f(-3, 6, -3), V3f(6, 0, 0), V3f(0, 0, 6), 1)}),
      accel::Kind::kdtree);
}

TEST(PathReuse, IsNotChosenForDirectLight) {
  const auto world = dark_world();
  const RenderOutcome outcome = render_open(*world, long_reuse_to_choose());
  EXPECT_EQ(outcome.statistics.path_reuse.count, 1);
  EXPECT_EQ(outcome.statistics.path_reuse.predicted, 1.0);
  EXPECT_GT(outcome.statistics.path_reuse.paths, 0U);
  expect_same_bits(outcome.film, render_open(*world, long_render(5)).film, "no reuse");
}

TEST(PathReuse, HasNoPilotWhereIndirectLightHasLittleNoise) {
  RenderSettings settings = long_reuse_to_choose();
  settings.chooses_direct_samples = true;
  const RenderOutcome outcome = render_open(*dark_world(), settings);
  EXPECT_GT(outcome.statistics.direct_samples.paths, 0U);
  EXPECT_EQ(outcome.statistics.path_reuse.paths, 0U);
  EXPECT_EQ(outcome.statistics.path_reuse.count, 1);
}

// The pilot of light samples measures the share of indirect light, and that of path reuse the part
// of it that falls.
TEST(PathReuse, IsChosenByTheShareOfIndirectLight) {
  const Camera camera = glass_camera(kPilotSize);
  const SamplePilotSettings pilot{
      .integrator = long_render(1).integrator, .filter = PixelFilter(PixelFilterOptions{}), .paths = uint64_t{1} << 18};
  const auto measured = [&](const World& world) {
    return choose_direct_samples(world, camera, pilot, {.lights = true}, {}).model;
  };
  const auto bright = indirect_world(), dark = dark_world();
  SampleModel model = measured(*bright);
  EXPECT_GT(model.of_indirect.value(), 0.8);
  EXPECT_LT(measured(*dark).of_indirect.value(), 0.05);

  const auto choose = [&] { return choose_path_reuse(*bright, camera, pilot, model, {}, {}); };
  EXPECT_EQ(choose().counts.pixels, static_cast<int>(kMaxPathReuse));
  const double predicted = choose().sharing.predicted;
  model.of_indirect = 0.3;
  EXPECT_GT(choose().sharing.predicted, predicted);
  EXPECT_GT(choose().sharing.paths, 0U);
  model.of_indirect = 0.01;
  EXPECT_EQ(choose().counts.pixels, 1);
  EXPECT_EQ(choose().sharing.paths, 0U);
}

TEST(PathReuse, PilotsHaveMoreBlocksBesideABackground) {
  EXPECT_EQ(paths_beside_background(1000, 1.0), 1000U);
  EXPECT_EQ(paths_beside_background(1000, 0.8), 1250U);
  EXPECT_EQ(paths_beside_background(1000, 0.1), 2000U);
}

TEST(PathReuse, HasNoPilotWhereItDoesNotWork) {
  const auto world = indirect_world();
  const auto expect_none = [&](const char* what, void (*change)(RenderSettings&)) {
    RenderSettings settings = long_reuse_to_choose();
    change(settings);
    const RenderOutcome outcome = render_open(*world, settings);
    EXPECT_EQ(outcome.statistics.path_reuse.paths, 0U) << what;
    EXPECT_EQ(outcome.statistics.path_reuse.count, 1) << what;
  };
  expect_none("a short render", [](RenderSettings& s) { s.planned_samples = 16; });
  expect_none("another tracer", [](RenderSettings& s) { s.integrator.kind = IntegratorKind::whitted; });
  expect_none("light paths", [](RenderSettings& s) { s.integrator.light_paths = 0.5f; });
  expect_none("direct light alone", [](RenderSettings& s) {
    s.integrator.max_bounces = s.integrator.max_diffuse_bounces = s.integrator.max_glossy_bounces = 0;
  });
}

// Pixels of a group have nearly the same noise. While samples are few, denoisers take it for
// texture.
TEST(PathReuse, IsNotChosenForFewSamplesThatAreDenoised) {
  const V2i size(160, 120);
  const auto world = indirect_world();
  const auto count = [&](uint32_t planned, bool denoised, bool limited) {
    RenderSettings settings = small_render(size, 1);
    settings.chooses_path_reuse = true;
    settings.planned_samples = planned;
    if (denoised) settings.aovs.insert(Aov::denoising_albedo);
    if (limited) settings.time_limit_s = 1000.0;
    return render_open(*world, settings).statistics.path_reuse.count;
  };
  EXPECT_GT(count(63, false, false), 1);
  EXPECT_EQ(count(63, true, false), 1);
  EXPECT_GT(count(64, true, false), 1);
  EXPECT_GT(count(64, false, true), 1);
  EXPECT_EQ(count(64, true, true), 1) << "the limit may leave few samples";
}

TEST(PathReuse, IsTheSameForThreadsPartsCropsAndDevices) {
  expect_same_choice_everywhere(*indirect_world(), kNumberOfPixels);
}

TEST(PathReuse, ResumedRendersKeepTheChoice) { expect_stored_choice(*indirect_world(), kNumberOfPixels); }

TEST(PathReuse, IsRefusedByNameWhereItDoesNotWork) {
  const Camera camera = glass_camera(kPilotSize);
  const auto expect_refusal = [&](const std::string& what, void (*change)(RenderSettings&)) {
    RenderSettings settings = reusing(kPilotSize, 1, 4);
    change(settings);
    const Result<void> checked = check_settings(settings, camera);
    ASSERT_FALSE(checked.ok()) << what;
    EXPECT_EQ(checked.error().message, "--path-reuse: not " + what);
  };
  EXPECT_TRUE(check_settings(reusing(kPilotSize, 1, 4), camera).ok());
  expect_refusal("with --integrator whitted; use path",
                 [](RenderSettings& s) { s.integrator.kind = IntegratorKind::whitted; });
  expect_refusal("with --light-paths; use 0", [](RenderSettings& s) { s.integrator.light_paths = 0.5f; });
  expect_refusal("with --light-paths; use 0", [](RenderSettings& s) { s.chooses_light_paths = true; });
  expect_refusal("with --manifold-samples; use 0", [](RenderSettings& s) { s.integrator.manifold_samples = 2; });
  expect_refusal("with --photons; use 0", [](RenderSettings& s) { s.integrator.photons = 0.5f; });
  expect_refusal("with --caustics off or regularized; use full",
                 [](RenderSettings& s) { s.integrator.caustics = Caustics::regularized; });
  expect_refusal("with --sample-rates noise; use even",
                 [](RenderSettings& s) { s.sample_rates = SampleRateKind::noise; });
  expect_refusal("with fewer diffuse or glossy bounces than --max-bounces 8",
                 [](RenderSettings& s) { s.integrator.max_glossy_bounces = 1; });
  for (const int count : {0, -2, 3, 16}) {
    const Result<void> checked = check_settings(reusing(kPilotSize, 1, count), camera);
    ASSERT_FALSE(checked.ok()) << count;
    EXPECT_EQ(checked.error().message, "path reuse " + std::to_string(count) + ": 1, 2, 4 or 8 is needed");
  }
  const Camera moving(SceneCamera{}, look_at(V3f(0, 4, 7), V3f(0.0f)), kPilotSize, CameraMotion{.shutter_open = true});
  EXPECT_EQ(check_settings(reusing(kPilotSize, 1, 4), moving).error().message,
            "--path-reuse: not with motion blur; leave out the shutter, such as by --shutter 0,0");
}

} // namespace
} // namespace kindling::test
