// Light samples at the first surface: a pilot chooses them, the same for all runs and devices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"
#include "renderer/session/check_settings.h"
#include "renderer/session/prepare/prepare_paths.h"
#include "tests/session/pilot_renders.h"

#include <string>
#include <vector>

namespace kindling::test {
namespace {

constexpr ChosenNumber kNumberOfLights{
    &RenderSettings::chooses_direct_samples,
    [](const RenderStatistics& s) -> const SampleChoice& { return s.direct_samples; },
    [](const RenderStatistics& s) { return s.direct_samples.count; }, &RenderWork::direct_samples,
    &IntegratorSettings::direct_samples};
RenderSettings long_render_to_choose() { return long_render_to_choose(kNumberOfLights, 5); }

// Dark things under a large lamp: almost all noise is in the penumbras.
std::unique_ptr<const World> penumbra_world() {
  return make_world(
      make_scene({diffuse_material(Rgb(0.1f)), emissive_material(Rgb(5.0f))},
                 {quad(V3f(-8, 0, 8), V3f(16, 0, 0), V3f(0, 0, -16), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 16, 0),
                  sphere(V3f(-2, 0.8f, 1), 0.6f, 16, 0), sphere(V3f(2, 0.8f, 1), 0.6f, 16, 0),
                  quad(V3f(-3, 6, -3), V3f(6, 0, 0), V3f(0, 0, 6), 1)}),
      accel::Kind::kdtree);
}

double noise_at(const World& world, int samples) {
  RenderSettings settings = long_render(16);
  settings.integrator.direct_samples = samples;
  return relative_noise(world, settings, 1e-4);
}

TEST(DirectSamples, AreChosenWhereShadowsAreNoisy) {
  const auto world = penumbra_world();
  const RenderOutcome outcome = render_open(*world, long_render_to_choose());
  const SampleChoice& choice = outcome.statistics.direct_samples;
  EXPECT_GE(choice.count, 3);
  EXPECT_LT(choice.predicted, 1.0 / kMinDirectSampleGain);
  EXPECT_GT(choice.paths, 0U);
  EXPECT_LT(noise_at(*world, choice.count), 0.6 * noise_at(*world, 1));
  expect_same_when_given(*world, kNumberOfLights, outcome);
}

// A point light has one direction, and a floor that nothing shades no noise at all. A probe finds
// out.
TEST(DirectSamples, AreOneWhereTheyGainNothing) {
  Scene scene = make_scene({diffuse_material(Rgb(0.7f))},
                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 32, 0)});
  PunctualLight lamp;
  lamp.intensity = 20.0f;
  place_light(scene, lamp, look_at(V3f(2, 6, 2), V3f(0.0f)));
  const auto world = make_world(std::move(scene), accel::Kind::kdtree);
  const RenderOutcome outcome = render_open(*world, long_render_to_choose());
  EXPECT_EQ(outcome.statistics.direct_samples.count, 1);
  EXPECT_EQ(outcome.statistics.direct_samples.predicted, 1.0);
  EXPECT_GT(outcome.statistics.direct_samples.paths, 0U);
  const RenderOutcome whole_pilot = render_open(*penumbra_world(), long_render_to_choose());
  EXPECT_LT(outcome.statistics.direct_samples.paths, whole_pilot.statistics.direct_samples.paths / 3);
  RenderSettings one = long_render_to_choose();
  one.chooses_direct_samples = false;
  expect_same_bits(outcome.film, render_open(*world, one).film, "one sample");
}

TEST(DirectSamples, ShortRendersAndOtherTracersHaveNoPilot) {
  const auto world = penumbra_world();
  RenderSettings settings = long_render_to_choose();
  settings.planned_samples = 16;
  EXPECT_EQ(render_open(*world, settings).statistics.direct_samples.paths, 0U);
  settings = long_render_to_choose();
  settings.integrator.kind = IntegratorKind::whitted;
  EXPECT_EQ(render_open(*world, settings).statistics.direct_samples.paths, 0U);
  settings = long_render_to_choose();
  settings.integrator.light_paths = 0.5f;
  EXPECT_EQ(render_open(*world, settings).statistics.direct_samples.paths, 0U);
}

TEST(DirectSamples, AreTheSameForThreadsPartsCropsAndDevices) {
  expect_same_choice_everywhere(*penumbra_world(), kNumberOfLights);
}

TEST(DirectSamples, ResumedRendersKeepTheChoice) { expect_stored_choice(*penumbra_world(), kNumberOfLights); }

TEST(DirectSamples, AreReplayed) { expect_replayed(*penumbra_world(), kNumberOfLights); }

TEST(DirectSamples, OutOfRangeAndBesideLightPathsAreRefused) {
  const Camera camera = glass_camera(kPilotSize);
  RenderSettings settings = small_render(kPilotSize, 1);
  for (const int samples : {0, -1, kMaxDirectSamples + 1}) {
    settings.integrator.direct_samples = samples;
    const Result<void> checked = check_settings(settings, camera);
    ASSERT_FALSE(checked.ok()) << samples;
    EXPECT_EQ(checked.error().message, "direct_samples " + std::to_string(samples) + ": 1 to 16 is needed");
  }
  settings.integrator.direct_samples = 2;
  EXPECT_TRUE(check_settings(settings, camera).ok());
  settings.integrator.light_paths = 0.5f;
  EXPECT_EQ(check_settings(settings, camera).error().message, "--light-paths: not with --direct-samples above 1");
}

} // namespace
} // namespace kindling::test
