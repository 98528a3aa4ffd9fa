// Reflection samples at the first surface: a pilot chooses them, the same for all runs and devices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/direct_sample_pilot.h"
#include "renderer/session/check_settings.h"
#include "tests/light/light_fixtures.h"
#include "tests/session/pilot_renders.h"

#include <string>
#include <vector>

namespace kindling::test {
namespace {

constexpr ChosenNumber kNumberOfReflections{
    &RenderSettings::chooses_reflection_samples,
    [](const RenderStatistics& s) -> const SampleChoice& { return s.direct_samples; },
    [](const RenderStatistics& s) { return s.direct_samples.reflections; },
    &RenderWork::reflection_samples,
    &IntegratorSettings::reflection_samples,
    0};

// A dim sky with a row of bright windows.
std::shared_ptr<const Environment> sky_with_windows() {
  return std::make_shared<Environment>(float_image(64, 32,
                                                   [](int x, int y) {
                                                     const bool window = y > 8 && y < 12 && x % 8 == 0;
                                                     return Rgb(window ? 8.0f : 0.2f);
                                                   }),
                                       0.0f, 1.0f);
}

// Dark spheres, coated or not.
std::unique_ptr<const World> sphere_world(float clearcoat) {
  Material dark = diffuse_material(Rgb(0.02f));
  dark.clearcoat_factor = clearcoat;
  dark.clearcoat_roughness_factor = 0.2f;
  return make_world(make_scene({dark}, {quad(V3f(-8, 0, 8), V3f(16, 0, 0), V3f(0, 0, -16), 0),
                                        sphere(V3f(0, 1.2f, 0), 1.0f, 32, 0), sphere(V3f(-2, 0.8f, 1), 0.6f, 32, 0)}),
                    accel::Kind::kdtree, sky_with_windows());
}

double noise_with(const World& world, int reflections) {
  RenderSettings settings = long_render(16);
  settings.integrator.reflection_samples = reflections;
  return relative_noise(world, settings, 1e-4);
}

TEST(ReflectionSamples, AreChosenForCoats) {
  const auto world = sphere_world(1.0f);
  const RenderSettings open = long_render_to_choose(kNumberOfReflections, 5);
  const RenderOutcome outcome = render_open(*world, open);
  const DirectSampleChoice& choice = outcome.statistics.direct_samples;
  EXPECT_EQ(choice.count, 1); // given
  EXPECT_GE(choice.reflections, 1);
  EXPECT_LT(choice.predicted, 1.0 / kMinDirectSampleGain);
  EXPECT_FALSE(outcome.work.direct_samples);
  EXPECT_LT(noise_with(*world, choice.reflections), 0.7 * noise_with(*world, 0));
  expect_same_when_given(*world, kNumberOfReflections, outcome);
}

TEST(ReflectionSamples, AreChosenTogetherWithLightSamples) {
  RenderSettings open = long_render_to_choose(kNumberOfReflections, 1);
  open.chooses_direct_samples = true;
  const auto world = sphere_world(1.0f);
  const RenderOutcome outcome = render_open(*world, open);
  const DirectSampleChoice& both = outcome.statistics.direct_samples;
  EXPECT_GE(both.reflections, 1);
  EXPECT_EQ(outcome.work.direct_samples, both.count);
  EXPECT_EQ(outcome.work.reflection_samples, both.reflections);
  EXPECT_LT(both.predicted, 1.0 / kMinDirectSampleGain);
}

// Lambertian surfaces have no lobe for them, and a lamp is no environment.
TEST(ReflectionSamples, AreNotChosenWithoutGlossyLobes) {
  const auto matte = sphere_world(0.0f);
  const RenderSettings open = long_render_to_choose(kNumberOfReflections, 1);
  const RenderOutcome outcome = render_open(*matte, open);
  EXPECT_EQ(outcome.statistics.direct_samples.reflections, 0);
  EXPECT_GT(outcome.statistics.direct_samples.paths, 0U);
  expect_same_bits(outcome.film, render_open(*matte, long_render(1)).film, "no reflection samples");
  const auto lamp = glass_world(accel::Kind::kdtree);
  EXPECT_EQ(render_open(*lamp, open).statistics.direct_samples.paths, 0U);
}

TEST(ReflectionSamples, AreTheSameForThreadsPartsCropsAndDevices) {
  expect_same_choice_everywhere(*sphere_world(1.0f), kNumberOfReflections);
}

TEST(ReflectionSamples, ResumedRendersKeepTheChoice) {
  expect_stored_choice(*sphere_world(1.0f), kNumberOfReflections);
}

TEST(ReflectionSamples, AreReplayed) { expect_replayed(*sphere_world(1.0f), kNumberOfReflections); }

TEST(ReflectionSamples, OutOfRangeAndBesideLightPathsAreRefused) {
  const Camera camera = glass_camera(kPilotSize);
  RenderSettings settings = small_render(kPilotSize, 1);
  for (const int samples : {-1, kMaxReflectionSamples + 1}) {
    settings.integrator.reflection_samples = samples;
    const Result<void> checked = check_settings(settings, camera);
    ASSERT_FALSE(checked.ok()) << samples;
    EXPECT_EQ(checked.error().message, "reflection_samples " + std::to_string(samples) + ": 0 to 4 is needed");
  }
  settings.integrator.reflection_samples = 2;
  EXPECT_TRUE(check_settings(settings, camera).ok());
  settings.integrator.light_paths = 0.5f;
  EXPECT_EQ(check_settings(settings, camera).error().message, "--light-paths: not with --reflection-samples above 0");
}

} // namespace
} // namespace kindling::test
