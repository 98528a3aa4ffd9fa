// A pilot chooses photons where they pay off; all runs, parts and threads choose the same.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/prepare/choose_photons.h"
#include "tests/integrator/place_light.h"
#include "tests/session/pilot_renders.h"

#include <string>
#include <vector>

namespace kindling::test {
namespace {

RenderSettings photons_open(uint32_t samples = 5) {
  RenderSettings settings = long_render(samples);
  settings.chooses_photons = true;
  return settings;
}

RenderSettings given_photons(float fraction, uint32_t samples = 5) {
  RenderSettings settings = long_render(samples);
  settings.integrator.photons = fraction;
  return settings;
}

TEST(ChoosePhotons, ChoosesThemWhereLightComesThroughGlass) {
  const auto world = lamp_world(accel::Kind::kdtree);
  const RenderOutcome outcome = render_open(*world, photons_open());
  const PhotonChoice& choice = outcome.statistics.photons;
  EXPECT_GT(choice.fraction, 0.0f);
  EXPECT_LE(choice.fraction, max_chosen_photons(kPilotSize));
  EXPECT_LT(choice.predicted, 1.0 / kMinPhotonGain);
  EXPECT_GT(choice.paths, 0U);
  EXPECT_GT(choice.rays.photon, 0U);
  EXPECT_EQ(choice.why_none, "");
  EXPECT_EQ(outcome.work.photons, choice.fraction);
  const RenderOutcome given = render_open(*world, given_photons(choice.fraction));
  expect_same_bits(outcome.film, given.film, "the chosen fraction");
  EXPECT_EQ(given.statistics.photons.paths, 0U);
  EXPECT_EQ(given.statistics.photons.fraction, choice.fraction);
  // A fraction that is given is taken.
  RenderSettings both = given_photons(1.0f);
  both.chooses_photons = true;
  EXPECT_EQ(render_open(*world, both).statistics.photons.fraction, 1.0f);
}

// A lamp of half a meter above a glass sphere, which paths from the camera find with noise.
std::unique_ptr<const World> caustic_world() {
  Material glass = diffuse_material(Rgb(1.0f));
  glass.roughness_factor = 0.0f;
  glass.specular_factor = glass.transmission_factor = glass.thickness_factor = 1.0f;
  return make_world(
      make_scene({diffuse_material(Rgb(0.7f)), glass, emissive_material(Rgb(30.0f))},
                 {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 48, 1),
                  quad(V3f(-0.25f, 5, -0.25f), V3f(0.5f, 0, 0), V3f(0, 0, 0.5f), 2)}),
      accel::Kind::kdtree);
}

TEST(ChoosePhotons, LessNoiseWithThem) {
  const auto world = caustic_world();
  RenderSettings settings = photons_open();
  settings.planned_samples = 4096; // a pilot that sees enough
  const PhotonChoice choice = choose_photons(*world, glass_camera(kPilotSize), settings, {}, nullptr);
  ASSERT_GT(choice.fraction, 0.0f);
  EXPECT_LT(relative_noise(*world, given_photons(choice.fraction, 32), 0.01),
            0.7 * relative_noise(*world, long_render(32), 0.01));
}

TEST(ChoosePhotons, CostNothingWithoutCasters) {
  const auto plain = make_world(make_scene({diffuse_material(Rgb(0.7f)), emissive_material(Rgb(5.0f))},
                                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0),
                                            quad(V3f(-0.5f, 5, -0.5f), V3f(1, 0, 0), V3f(0, 0, 1), 1)}),
                                accel::Kind::kdtree);
  const RenderOutcome outcome = render_open(*plain, photons_open());
  EXPECT_EQ(outcome.statistics.photons.fraction, 0.0f);
  EXPECT_EQ(outcome.statistics.photons.rays.total(), 0U);
  EXPECT_NE(outcome.statistics.photons.why_none.find("no light reaches glass, metal or a coat"), std::string::npos);
  expect_same_bits(outcome.film, render_open(*plain, long_render(5)).film, "no casters");
}

// Rough metal that is evenly lit from everywhere: photons find what paths find without noise, and
// cost time.
std::unique_ptr<const World> evenly_lit_metal() {
  Material metal = diffuse_material(Rgb(0.5f));
  metal.metallic_factor = 1.0f;
  metal.roughness_factor = 0.3f;
  return make_world(make_scene({diffuse_material(Rgb(0.7f)), metal, emissive_material(Rgb(1.0f))},
                               {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1, 0), 0.4f, 32, 1),
                                sphere(V3f(0, 0, 0), 40.0f, 32, 2)}),
                    accel::Kind::kdtree);
}

TEST(ChoosePhotons, NoneWhereTheyGainNothing) {
  const auto world = evenly_lit_metal();
  const RenderOutcome outcome = render_open(*world, photons_open());
  EXPECT_GT(outcome.statistics.photons.paths, 0U);
  EXPECT_EQ(outcome.statistics.photons.fraction, 0.0f);
  EXPECT_EQ(outcome.work.photons, 0.0f);
  expect_same_bits(outcome.film, render_open(*world, long_render(5)).film, "none");
}

// The pilot does not see the guide, which is trained beside the photons, and once.
TEST(ChoosePhotons, AreChosenBeforeTheGuideIsTrained) {
  const auto world = lamp_world(accel::Kind::kdtree);
  RenderSettings settings = photons_open();
  const PhotonChoice unguided = render_open(*world, settings).statistics.photons;
  ASSERT_GT(unguided.fraction, 0.0f);
  settings.guiding = Guiding::on;
  const RenderOutcome outcome = render_open(*world, settings);
  EXPECT_EQ(outcome.statistics.photons.fraction, unguided.fraction);
  EXPECT_EQ(outcome.statistics.photons.predicted, unguided.predicted);
  RenderSettings given = given_photons(unguided.fraction);
  given.guiding = Guiding::on;
  const RenderOutcome beside = render_open(*world, given);
  expect_same_bits(outcome.film, beside.film, "beside photons");
  ASSERT_GT(beside.statistics.guiding.paths, 0U);
  EXPECT_EQ(outcome.statistics.guiding.paths, beside.statistics.guiding.paths);
  EXPECT_EQ(outcome.statistics.guiding.rays.total(), beside.statistics.guiding.rays.total());
}

// Without photons the numbers of samples are chosen beside the guide, as if none had been asked
// for. What their pilots cost before that counts, too.
TEST(ChoosePhotons, LeaveOtherChoicesToAGuideWithoutThem) {
  const auto world = evenly_lit_metal();
  RenderSettings settings = photons_open();
  settings.guiding = Guiding::on;
  settings.chooses_direct_samples = settings.chooses_reflection_samples = settings.chooses_path_reuse = true;
  const RenderOutcome outcome = render_open(*world, settings);
  ASSERT_GT(outcome.statistics.photons.paths, 0U);
  ASSERT_EQ(outcome.statistics.photons.fraction, 0.0f);
  ASSERT_GT(outcome.statistics.guiding.patches, 0) << "no guide, so nothing is tested";
  settings.chooses_photons = false;
  const RenderOutcome without = render_open(*world, settings);
  expect_same_bits(outcome.film, without.film, "photons that are not chosen");
  EXPECT_EQ(outcome.statistics.direct_samples.predicted, without.statistics.direct_samples.predicted);
  EXPECT_GT(outcome.statistics.direct_samples.paths, without.statistics.direct_samples.paths);
  EXPECT_GT(outcome.statistics.direct_samples.busy_s, 0.0);
}

// A sphere of smooth glass below a lamp of 20 watts per steradian.
std::unique_ptr<const World> sphere_below_lamp(float radius_m) {
  Material glass = diffuse_material(Rgb(1.0f));
  glass.roughness_factor = 0.0f;
  glass.specular_factor = glass.transmission_factor = glass.thickness_factor = 1.0f;
  Scene scene = make_scene({diffuse_material(Rgb(0.7f)), glass},
                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 32, 1)});
  PunctualLight lamp;
  lamp.intensity = 20.0f;
  lamp.radius_m = radius_m;
  place_light(scene, lamp, look_at(V3f(0.5f, 6, 0.5f), V3f(0.0f)));
  return make_world(std::move(scene), accel::Kind::kdtree);
}

// Paths from the camera hardly ever meet so small a lamp: its caustic is missing without photons.
TEST(ChoosePhotons, FindLightThatPathsHardlyEverFind) {
  const auto world = sphere_below_lamp(0.0005f);
  const PhotonChoice choice = choose_photons(*world, glass_camera(kPilotSize), photons_open(), {}, nullptr);
  EXPECT_GT(choice.fraction, 0.0f);
  EXPECT_LT(choice.predicted, 0.5);
}

// Light of a lamp without a size would come and go with the choice.
TEST(ChoosePhotons, NoneWithLampsWithoutASize) {
  const auto world = sphere_below_lamp(0.0f);
  PilotMessages messages;
  const PhotonChoice choice = choose_photons(*world, glass_camera(kPilotSize), photons_open(), {}, &messages);
  EXPECT_EQ(choice.fraction, 0.0f);
  EXPECT_EQ(choice.paths, 0U);
  ASSERT_EQ(messages.notes.size(), 1U);
  EXPECT_NE(messages.notes[0].find("lamps without a size"), std::string::npos) << messages.notes[0];
}

TEST(ChoosePhotons, DoNotDependOnThreadsSamplesRegionsAndDevices) {
  const auto world = lamp_world(accel::Kind::kdtree);
  const RenderOutcome whole = render_open(*world, photons_open());
  const PhotonChoice& expected = whole.statistics.photons;
  ASSERT_GT(expected.fraction, 0.0f);
  const auto expect_same_choice = [&](const RenderSettings& settings, const char* where) {
    const RenderOutcome outcome = render_open(*world, settings);
    EXPECT_EQ(outcome.statistics.photons.fraction, expected.fraction) << where;
    EXPECT_EQ(outcome.statistics.photons.predicted, expected.predicted) << where;
    EXPECT_EQ(outcome.statistics.photons.rays.total(), expected.rays.total()) << where;
    return outcome;
  };
  RenderSettings settings = photons_open();
  settings.threads = 3;
  settings.tile_size_px = 8;
  expect_same_bits(expect_same_choice(settings, "threads").film, whole.film, "threads");
  settings.region = PixelRect{V2i(8, 8), V2i(24, 16)};
  settings.samples = SampleRange{2, 3};
  (void)expect_same_choice(settings, "a part");
  settings = photons_open();
  settings.crop = PixelRect{V2i(5, 3), V2i(30, 28)};
  expect_same_bits(expect_same_choice(settings, "a crop").film, whole.film, "a crop");
  settings = photons_open();
  settings.device = DeviceKind::host;
  expect_same_bits(expect_same_choice(settings, "a device").film, whole.film, "a device");
}

TEST(ChoosePhotons, SmallCropsWarnOfThoseOfTheWholeImage) {
  const auto world = lamp_world(accel::Kind::kdtree);
  const auto warnings = [&](const PixelRect& crop, const RenderSettings& of_image) {
    RenderSettings settings = of_image;
    settings.crop = crop;
    PilotMessages messages;
    EXPECT_TRUE(render(*world, glass_camera(kPilotSize), settings, nullptr, &messages).ok());
    return messages.warnings;
  };
  const std::vector<std::string> small = warnings({V2i(4, 8), V2i(8, 12)}, photons_open());
  ASSERT_EQ(small.size(), 1U);
  EXPECT_NE(small[0].find("--photons 0"), std::string::npos) << small[0];
  EXPECT_EQ(warnings({V2i(0), V2i(40, 28)}, photons_open()).size(), 0U);
  EXPECT_EQ(warnings({V2i(4, 8), V2i(8, 12)}, given_photons(0.25f)).size(), 0U); // as asked for
}

TEST(ChoosePhotons, ResumedRendersKeepTheChoice) {
  const auto world = lamp_world(accel::Kind::kdtree);
  const Film whole = render_open(*world, photons_open(9)).film;
  std::optional<RenderState> saved;
  (void)render_open(*world, photons_open(4), {.save = [&](const RenderState& state) { saved = state; }});
  ASSERT_TRUE(saved);
  ASSERT_GT(saved->work.photons.value_or(0.0f), 0.0f);
  RenderSettings longer = photons_open(9);
  longer.time_limit_s = 1000.0; // another pilot would choose
  const RenderOutcome outcome = render_open(*world, longer, {.resume_from = saved});
  EXPECT_EQ(outcome.statistics.photons.paths, 0U);
  EXPECT_EQ(outcome.statistics.photons.fraction, *saved->work.photons);
  expect_same_bits(outcome.film, whole, "a resumed render");
}

// A render that was stopped before its first sample has chosen nothing.
TEST(ChoosePhotons, StoppedPilotsChooseLater) {
  const auto world = lamp_world(accel::Kind::kdtree);
  CancelToken token;
  token.cancel_now();
  const RenderOutcome stopped = render_open(*world, photons_open(), {}, &token);
  EXPECT_EQ(stopped.statistics.photons.fraction, 0.0f);
  RenderState state{
      Film(kPilotSize, {V2i(0), kPilotSize}, photons_open().aovs), Coverage({V2i(0), kPilotSize}), {}, stopped.work};
  const RenderOutcome outcome = render_open(*world, photons_open(), {.resume_from = std::move(state)});
  EXPECT_GT(outcome.statistics.photons.fraction, 0.0f);
  expect_same_bits(outcome.film, render_open(*world, photons_open()).film, "a render that began again");
}

// Light samples are chosen before; photons take the place of path reuse.
TEST(ChoosePhotons, BesideLightSamplesAndInPlaceOfPathReuse) {
  const auto world = caustic_world();
  RenderSettings settings = photons_open();
  settings.chooses_direct_samples = settings.chooses_reflection_samples = settings.chooses_path_reuse = true;
  const RenderOutcome outcome = render_open(*world, settings);
  ASSERT_GT(outcome.statistics.photons.fraction, 0.0f);
  EXPECT_EQ(outcome.statistics.path_reuse.count, 1);
  EXPECT_EQ(outcome.work.path_reuse, 1);
  RenderSettings given = given_photons(outcome.statistics.photons.fraction);
  given.integrator.direct_samples = outcome.statistics.direct_samples.count;
  given.integrator.reflection_samples = outcome.statistics.direct_samples.reflections;
  expect_same_bits(outcome.film, render_open(*world, given).film, "the chosen numbers");
}

TEST(ChoosePhotons, AreOffBesideOtherSettings) {
  const auto expect_none = [](const char* words, void (*change)(RenderSettings&)) {
    expect_no_choice(photons_open(2), &RenderSettings::chooses_photons, &RenderStatistics::photons,
                     &PhotonChoice::paths, words, change);
  };
  expect_none("not with --clamp-indirect", [](RenderSettings& s) { s.integrator.clamp_indirect = 1.0f; });
  expect_none("not with --light-paths", [](RenderSettings& s) { s.integrator.light_paths = 0.5f; });
  expect_none("with --photons", [](RenderSettings& s) { s.integrator.manifold_samples = 1; });
  expect_none("with --photons; use 0", [](RenderSettings& s) { s.integrator.path_reuse = 4; });
  expect_none("with --integrator whitted", [](RenderSettings& s) { s.integrator.kind = IntegratorKind::whitted; });
  expect_none("too short for a pilot", [](RenderSettings& s) { s.planned_samples = 16; });
}

// A replayed sample gathers from the maps of the render.
TEST(ChoosePhotons, ReplaysGatherThem) {
  const auto world = lamp_world(accel::Kind::kdtree);
  const RenderSettings open = photons_open(1);
  LearnedPaths learned;
  const RenderOutcome outcome =
      render_open(*world, open, {.after_training = [&](const LearnedPaths& by_render) { learned = by_render; }});
  EXPECT_EQ(learned.photons, outcome.statistics.photons.fraction);
  const std::vector<float> image = outcome.film.resolve(Aov::beauty);
  const Camera camera = glass_camera(kPilotSize);
  bool differ = false;
  for (const V2i& pixel : {V2i(8, 18), V2i(20, 22), V2i(30, 26)}) {
    const Rgb found = replay_sample(*world, camera, open, learned, pixel, 0).value().radiance;
    EXPECT_EQ(found, replay_sample(*world, camera, open, pixel, 0).value().radiance);
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_EQ(image[static_cast<size_t>((pixel.y * kPilotSize.x + pixel.x) * 3 + channel)], found[channel]);
    LearnedPaths without = learned;
    without.photons = 0.0f;
    differ |= !(found == replay_sample(*world, camera, open, without, pixel, 0).value().radiance);
  }
  EXPECT_TRUE(differ);
}

TEST(ChoosePhotons, LargeImagesHaveSmallMaps) {
  EXPECT_EQ(max_chosen_photons(V2i(640, 360)), 0.25f);
  const V2i large(7680, 4320);
  EXPECT_LE(max_chosen_photons(large) * 7680.0f * 4320.0f, 262145.0f);
  EXPECT_GT(max_chosen_photons(large), 0.0f);
}

} // namespace
} // namespace kindling::test
