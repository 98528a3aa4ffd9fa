// Noise that pilots measure: of all channels alike, and the same in every call.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/pilots/block_noise.h"
#include "tests/session/pilot_renders.h"

#include <functional>

namespace kindling::test {
namespace {

constexpr NoiseBlocks kBlocks{.side = 4, .samples = 4};
constexpr uint64_t kPaths = 1U << 15;

// A floor in one color, lit by a lamp and by way of a wall in another one.
std::unique_ptr<const World> colored_world(const Rgb& floor, const Rgb& wall) {
  return make_world(
      make_scene({diffuse_material(floor), diffuse_material(wall), emissive_material(Rgb(20.0f), Rgb(0.5f))},
                 {quad(V3f(-4, 0, 8), V3f(8, 0, 0), V3f(0, 0, -12), 0),
                  quad(V3f(-4, 0, -4), V3f(8, 0, 0), V3f(0, 6, 0), 1),
                  quad(V3f(-1, 4.5f, 0), V3f(2, 0, 0), V3f(0, 0, 2), 2)}),
      accel::Kind::kdtree);
}

// A survey of one light sample and of eight.
struct Survey {
  std::unique_ptr<const World> world;
  Camera camera = glass_camera(kPilotSize);
  SamplePilotSettings settings{.integrator = long_render(1).integrator, .filter = PixelFilter(PixelFilterOptions{})};
  std::function<bool()> never;
  NoiseSurvey survey{
      *world,
      camera,
      settings,
      kBlocks,
      [](IntegratorSettings& integrator, size_t setting) { integrator.direct_samples = setting == 0 ? 1 : 8; },
      never};
  SampleChoice choice;

  MeasuredNoise measure(uint64_t paths = kPaths) { return survey.measure(paths, choice); }
};

// Diffuse surfaces and white light: paths do not depend on colors, so red and blue change places.
TEST(NoiseSurvey, EveryChannelCountsAsMuch) {
  const MeasuredNoise red = Survey{colored_world({0.9f, 0.5f, 0.02f}, {0.1f, 0.2f, 0.8f})}.measure();
  const MeasuredNoise blue = Survey{colored_world({0.02f, 0.5f, 0.9f}, {0.8f, 0.2f, 0.1f})}.measure();
  ASSERT_TRUE(red.complete && blue.complete);
  for (size_t setting = 0; setting < kBlocks.settings; ++setting) {
    EXPECT_GT(red.error.all[setting], 0.0);
    EXPECT_NEAR(red.error.all[setting], blue.error.all[setting], 1e-9 * red.error.all[setting]);
    EXPECT_NEAR(red.error.direct[setting], blue.error.direct[setting], 1e-9 * red.error.direct[setting]);
    EXPECT_NEAR(red.error.indirect[setting], blue.error.indirect[setting], 1e-9 * red.error.indirect[setting]);
  }
  EXPECT_LT(red.error.direct[1], red.error.direct[0]);
}

TEST(NoiseSurvey, EveryCallMeasuresTheSame) {
  Survey survey{colored_world({0.9f, 0.5f, 0.02f}, {0.1f, 0.2f, 0.8f})};
  const MeasuredNoise first = survey.measure();
  const uint64_t of_first = survey.choice.paths;
  EXPECT_GT(of_first, kPaths / 2);
  const MeasuredNoise second = survey.measure();
  EXPECT_EQ(first.error.all, second.error.all);
  EXPECT_EQ(first.camera_rays, second.camera_rays);
  EXPECT_EQ(survey.choice.paths, 2 * of_first);
  EXPECT_FALSE(survey.measure(kBlocks.paths_per_block() - 1).complete);
}

} // namespace
} // namespace kindling::test
