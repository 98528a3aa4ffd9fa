// Guided walks in media: their mean with any guide, their noise with learned ones, and photons.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/light_paths/volume_photons.h"
#include "renderer/session/prepare/train_guide.h"
#include "tests/integrator/guided_mean.h"
#include "tests/integrator/motion_scenes.h"
#include "tests/integrator/place_light.h"
#include "tests/integrator/wax_scene.h"
#include "tests/light/light_fixtures.h"

#include <tbb/task_arena.h>

#include <algorithm>

namespace kindling::test {
namespace {

constexpr V2i kSize(24, 24);

// Bright directions that have nothing to do with the scene's lights, others in each region.
Guide wild_volumes() {
  std::vector<VolumeRecord> records;
  for (uint32_t i = 0; i < 60000; ++i) {
    const V3f position(arbitrary(i, 0), arbitrary(i, 1), arbitrary(i, 2));
    const V3f wide = V3f(arbitrary(i, 3), arbitrary(i, 4), arbitrary(i, 5)) + V3f(0.0f, 0.0f, 0.01f);
    const V3f bright = V3f(position.y, -0.5f, position.x) + wide * 0.1f;
    records.push_back({position, (i % 3 == 0 ? wide : bright).normalized(), 1.0f});
  }
  Guide guide;
  guide.volumes = VolumeGuide(records);
  EXPECT_GT(guide.volumes.bright_region_count(), 10U);
  return guide;
}

// A medium that absorbs nothing is as bright as the light around it.
TEST(VolumeGuiding, WhiteMediumInAWhiteFurnaceIsWhite) {
  const Guide guide = wild_volumes();
  for (const float g : {0.0f, 0.7f, -0.5f}) {
    Material cloud = wax(0.0f, Rgb(1.0f), g);
    cloud.ior = 1.0f;
    cloud.attenuation_color = Rgb(0.1f, 0.3f, 0.5f);
    const auto world = make_world(make_scene({cloud}, {sphere(V3f(0.0f), 1.0f, 24, 0, false)}), accel::Kind::kdtree,
                                  std::make_shared<Environment>(Rgb(1.0f)));
    const Mean mean = guided_mean(*world, beam_camera(V3f(0, 0, 3), V3f(0.1f, 0.05f, 0), 1e-2f),
                                  small_render(V2i(8, 8), 1024), &guide);
    for (unsigned c = 0; c < 3; ++c)
      EXPECT_NEAR(mean.rgb[c], 1.0f, 4.5 * 4.0 * mean.standard_error + 1e-3) << g << " " << c;
    EXPECT_GT(mean.standard_error, 1e-4) << "the guide has no effect, so nothing is tested";
  }
}

// Smooth and rough boundaries, colored media, forward and backward scattering.
TEST(VolumeGuiding, ArbitraryGuidesKeepTheMean) {
  const Guide guide = wild_volumes();
  for (const auto& [roughness, g] : {std::pair(0.0f, 0.0f), std::pair(0.4f, 0.6f), std::pair(0.3f, -0.6f)}) {
    const auto world = make_world(wax_under_a_lamp(wax(roughness, Rgb(0.6f, 0.4f, 0.2f), g)), accel::Kind::kdtree,
                                  std::make_shared<Environment>(Rgb(2.0f)));
    RenderSettings settings = small_render(kSize, 256);
    settings.integrator.roulette_start_bounce = 3;
    const Mean without = guided_mean(*world, wax_camera(kSize), settings, nullptr);
    settings.seed = 1;
    const Mean with = guided_mean(*world, wax_camera(kSize), settings, &guide);
    const double error = std::hypot(with.standard_error, without.standard_error);
    EXPECT_NEAR(with.luminance, without.luminance, 4.5 * error) << roughness << " " << g;
    EXPECT_LT(error, 0.03 * with.luminance);
  }
}

RenderSettings trained(Guiding guiding, uint32_t spp) { return trained_render(kSize, spp, guiding, 20000); }

// A learned guide keeps the mean and lowers the noise: to a third in smooth wax, where paths alone
// find the lamp.
TEST(VolumeGuiding, LearnedGuidesFindTheLamp) {
  for (const auto& [roughness, limit] : {std::pair(0.0f, 0.45), std::pair(0.3f, 0.6)}) {
    const auto world = make_world(wax_under_a_lamp(wax(roughness, Rgb(0.6f))), accel::Kind::kdtree);
    const Mean off = render_mean(*world, wax_camera(kSize), trained(Guiding::off, 256));
    RenderSettings settings = trained(Guiding::automatic, 256);
    settings.seed = 1;
    const Result<RenderOutcome> outcome = render(*world, wax_camera(kSize), settings, nullptr, nullptr);
    ASSERT_TRUE(outcome.ok());
    EXPECT_GT(outcome.value().statistics.guiding.volume_regions, 0);
    const Mean on = mean_of(outcome.value().film);
    EXPECT_NEAR(on.luminance, off.luminance, 4.5 * std::hypot(on.standard_error, off.standard_error)) << roughness;
    EXPECT_LT(square(on.standard_error), limit * square(off.standard_error)) << roughness;
  }
}

TEST(VolumeGuiding, RendersDoNotDependOnThreads) {
  const auto world = make_world(wax_under_a_lamp(wax(0.2f, Rgb(0.8f, 0.5f, 0.4f))), accel::Kind::kdtree);
  EXPECT_GT(render_on_any_threads(*world, wax_camera(kSize), trained(Guiding::automatic, 8)).volume_regions, 0);
}

std::vector<VolumeRecord> photons_in(const World& world, uint64_t paths = 4000, uint32_t seed = 0) {
  RayCounters counters;
  return trace_volume_photons(world, {{}, seed, paths, 1U << 20}, {}, counters);
}

// Records lie in the sphere; of those that nothing has scattered before, most come from the lamp's
// side.
TEST(VolumePhotons, AreScatteredInTheMedium) {
  const auto world = make_world(wax_under_a_lamp(wax(0.0f, Rgb(0.6f))), accel::Kind::kdtree);
  const std::vector<VolumeRecord> records = photons_in(*world);
  ASSERT_GT(records.size(), 2000U);
  const V3f to_lamp = V3f(-2, 3, 1).normalized();
  size_t from_lamp = 0;
  for (const VolumeRecord& record : records) {
    ASSERT_LT(record.position.length(), 1.0f + 1e-4f);
    ASSERT_NEAR(record.direction.length(), 1.0f, 1e-5f);
    ASSERT_GT(record.weight, 0.0f);
    if (record.direction.dot(to_lamp) > 0.7f) ++from_lamp;
  }
  EXPECT_GT(from_lamp, records.size() / 4); // of 0.15 of all directions
}

TEST(VolumePhotons, AreNeededOnlyInMediaUnderLamps) {
  Scene dark = make_scene({wax(0.0f, Rgb(0.6f))}, {sphere(V3f(0.0f), 1.0f, 32, 0)});
  EXPECT_TRUE(photons_in(*make_world(dark, accel::Kind::kdtree)).empty());
  // No direction leads to a point.
  PunctualLight point;
  point.kind = PunctualLight::Kind::point;
  point.intensity = 10.0f;
  Scene pointed = dark;
  place_light(pointed, point, look_at(V3f(0, 3, 0.1f), V3f(0.0f)));
  EXPECT_TRUE(photons_in(*make_world(std::move(pointed), accel::Kind::kdtree)).empty());
  point.radius_m = 0.2f;
  Scene sized = dark;
  place_light(sized, point, look_at(V3f(0, 3, 0.1f), V3f(0.0f)));
  EXPECT_FALSE(photons_in(*make_world(std::move(sized), accel::Kind::kdtree)).empty());
  EXPECT_FALSE(photons_in(*make_world(wax_under_a_lamp(wax(0.0f, Rgb(0.6f))), accel::Kind::kdtree)).empty());
  EXPECT_TRUE(photons_in(*make_world(wax_under_a_lamp(wax(0.0f, Rgb(0.0f))), accel::Kind::kdtree)).empty());
}

// A lamp that grows while it moves and turns brings as much light in a second as on average at
// single times.
TEST(VolumePhotons, HaveAllTimesOfTheShutter) {
  Scene scene = wax_under_a_lamp(wax(0.0f, Rgb(0.6f)));
  animate(scene, 1, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 3.5f, -1.2f, 0});
  animate(scene, 1, AnimatedProperty::scale, {0, 1}, {1, 1, 1, 1.3f, 1, 1.5f});
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 0.3f, 0, 0.4f});
  const auto light_of = [](const World& world, uint32_t seed) {
    double sum = 0.0;
    for (const VolumeRecord& record : photons_in(world, 4096, seed)) sum += static_cast<double>(record.weight);
    return sum;
  };
  Estimate moving;
  const auto world = make_posed_world(scene, {.shutter = Shutter{0.0, 1.0}}, accel::Kind::kdtree);
  for (uint32_t seed = 0; seed < 32; ++seed) moving.add(light_of(*world, seed));
  constexpr uint32_t kTimes = 16;
  double mean = 0.0, variance = 0.0, first = 0.0;
  for (uint32_t i = 0; i < kTimes; ++i) {
    const auto still = make_posed_world(scene, {.time_s = (i + 0.5) / kTimes}, accel::Kind::kdtree);
    Estimate at_time;
    for (uint32_t seed = 0; seed < 4; ++seed) at_time.add(light_of(*still, 100 + 4 * i + seed));
    mean += at_time.mean() / kTimes;
    variance += square(at_time.standard_error() / kTimes);
    if (i == 0) first = at_time.mean();
  }
  EXPECT_NEAR(moving.mean(), mean, 5.0 * std::sqrt(square(moving.standard_error()) + variance) + 2e-3 * mean);
  EXPECT_LT(moving.standard_error(), 0.01 * mean);
  EXPECT_GT(std::abs(first - mean), 0.2 * mean); // the motion matters
}

TEST(VolumePhotons, DoNotDependOnThreads) {
  const auto world = make_world(wax_under_a_lamp(wax(0.1f, Rgb(0.6f))), accel::Kind::kdtree);
  std::vector<VolumeRecord> alone, together;
  tbb::task_arena(1).execute([&] { alone = photons_in(*world, 9000); });
  tbb::task_arena(3).execute([&] { together = photons_in(*world, 9000); });
  ASSERT_EQ(alone.size(), together.size());
  for (size_t i = 0; i < alone.size(); ++i)
    ASSERT_TRUE(alone[i].position == together[i].position && alone[i].direction == together[i].direction &&
                alone[i].weight == together[i].weight)
        << i;
}

} // namespace
} // namespace kindling::test
