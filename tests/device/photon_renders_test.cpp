// Photons on devices: the images of the CPU, to the bit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/render_session.h"
#include "tests/device/caster_scene.h"
#include "tests/device/parts_on_devices.h"
#include "tests/device/tested_device.h"
#include "tests/device/textured_scene.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>

namespace kindling::test {
namespace {

const V2i kPhotonImage(75, 53);

Camera photon_camera() { return {SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kPhotonImage}; }

// Maps are shared by 16 samples.
RenderSettings with_photons(uint32_t samples, float light_paths = 0.0f) {
  RenderSettings settings = small_render(kPhotonImage, samples);
  settings.integrator.photons = 1.0f;
  settings.integrator.light_paths = light_paths;
  return settings;
}

RenderOutcome outcome_on(DeviceKind device, const World& world, RenderSettings settings,
                         RenderContinuity continuity = {}, const Camera& camera = photon_camera()) {
  settings.device = device;
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr, std::move(continuity));
  EXPECT_TRUE(outcome.ok()) << outcome.error().message;
  return std::move(outcome).value();
}

void expect_same_with_photons(const World& world, const RenderSettings& settings,
                              const Camera& camera = photon_camera()) {
  const RenderOutcome expected = outcome_on(DeviceKind::cpu, world, settings, {}, camera);
  RenderSettings without = settings;
  without.integrator.photons = 0.0f;
  EXPECT_NE(outcome_on(DeviceKind::cpu, world, without, {}, camera).film.resolve(Aov::beauty),
            expected.film.resolve(Aov::beauty))
      << "nothing is tested";
  const RenderOutcome found = outcome_on(tested_device(), world, settings, {}, camera);
  expect_same_bits(found.film, expected.film, "the host device");
  const RayCounters &there = found.statistics.rays, &here = expected.statistics.rays;
  EXPECT_EQ(there.paths, here.paths);
  EXPECT_EQ(there.camera, here.camera);
  EXPECT_EQ(there.bounce, here.bounce);
  EXPECT_EQ(there.shadow, here.shadow);
  EXPECT_GT(there.photon, 0U);
}

TEST(PhotonsOnDevices, AllCastersAndLights) {
  for (const bool cut_out : {false, true})
    for (const float light_paths : {0.0f, 0.5f}) {
      SCOPED_TRACE((cut_out ? "coverage and thin walls, " : "all opaque, ") + std::to_string(light_paths));
      const auto world = caster_world(cut_out);
      expect_same_with_photons(*world, with_photons(7, light_paths));
    }
}

TEST(PhotonsOnDevices, AllMaterialsAndAovs) {
  RenderSettings settings = with_photons(5);
  settings.outliers = Outliers::trim;
  for (const AovInfo& info : kAovs)
    if (!is_light_pass(info.aov) && !is_motion(info.aov) && info.aov != Aov::shadow_catcher)
      settings.aovs.insert(info.aov);
  expect_same_with_photons(*mixed_world(accel::Kind::kdtree), settings);
}

TEST(PhotonsOnDevices, Motion) {
  expect_same_with_photons(*moving_glass_world(accel::Kind::kdtree), with_photons(20),
                           moving_glass_camera(kPhotonImage));
}

TEST(PhotonsOnDevices, Guiding) {
  RenderSettings settings = with_photons(8);
  settings.planned_samples = 64;
  settings.guiding = Guiding::on;
  expect_same_with_photons(*caster_world(true), settings);
}

// The samples are of three maps, and no pass begins with one.
TEST(PhotonsOnDevices, CropsSampleRangesAndAdaptiveSampling) {
  const auto world = caster_world(true);
  RenderSettings settings = with_photons(40);
  settings.crop = PixelRect{V2i(13, 9), V2i(50, 41)};
  settings.samples = SampleRange{7, 37};
  expect_same_with_photons(*world, settings);
  RenderSettings adaptive = with_photons(60, 0.25f);
  adaptive.adaptive = {.noise_threshold = 0.1, .min_samples_per_pixel = 20};
  adaptive.aovs.insert(Aov::samples);
  expect_same_with_photons(*world, adaptive);
}

// A pixel takes up to eight samples for each level, whose map they share.
TEST(PhotonsOnDevices, SeveralLightSamples) {
  const auto world = glass_world(accel::Kind::kdtree);
  RenderSettings settings = with_photons(4);
  settings.integrator.direct_samples = 3;
  expect_same_with_photons(*world, settings);
}

TEST(PhotonsOnDevices, SampleRates) {
  RenderSettings settings = with_photons(40);
  settings.sample_rates = SampleRateKind::noise;
  settings.min_rates_gain = 0.0;
  settings.aovs.insert(Aov::samples);
  expect_same_with_photons(*caster_world(false), settings);
}

TEST(PhotonsOnDevices, ScenesWithoutCasters) {
  const auto world = make_world(sphere_lamp_and_veil(0.6f), accel::Kind::kdtree);
  const RenderSettings settings = with_photons(3);
  expect_same_bits(outcome_on(tested_device(), *world, settings).film,
                   outcome_on(DeviceKind::cpu, *world, settings).film, "no casters");
}

TEST(PhotonsOnDevices, PartsOfDifferentDevicesAddUp) {
  const auto world = caster_world(true);
  expect_parts_of_devices_add_up(
      with_photons(40, 0.3f), {{21, 40}, {0, 5}, {5, 21}},
      [&](DeviceKind device, const RenderSettings& settings) { return outcome_on(device, *world, settings).film; });
}

TEST(PhotonsOnDevices, ResumeWhereAnotherDeviceStopped) {
  const auto world = caster_world(true);
  RenderSettings settings = with_photons(9);
  settings.planned_samples = 20;
  settings.samples_per_pixel = 20;
  const Film expected = outcome_on(DeviceKind::cpu, *world, settings).film;
  for (const DeviceKind first : {DeviceKind::cpu, tested_device()}) {
    settings.samples_per_pixel = 9;
    std::optional<RenderState> saved;
    (void)outcome_on(first, *world, settings, {.save = [&](const RenderState& state) { saved.emplace(state); }});
    ASSERT_TRUE(saved);
    settings.samples_per_pixel = 20;
    const DeviceKind second = first == DeviceKind::cpu ? tested_device() : DeviceKind::cpu;
    expect_same_bits(outcome_on(second, *world, settings, {.resume_from = std::move(saved)}).film, expected,
                     std::string(device_kind_name(first)) + " first");
  }
}

// Maps take memory beside small waves and tiles of textures; paths that gather wait for tiles.
TEST(PhotonsOnDevices, MapsCountInTheMemory) {
  const auto world = textured_world();
  RenderSettings settings = with_photons(20);
  settings.planned_samples = 256; // for small footprints
  RenderSettings too_small = settings;
  too_small.device = tested_device();
  too_small.device_memory_bytes = 1 << 16;
  const Result<RenderOutcome> refused = render(*world, photon_camera(), too_small, nullptr, nullptr);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find(", photons 10.2 MiB, "), std::string::npos) << refused.error().message;
  // The figure is enough.
  const std::string needs = "needs at least ";
  const size_t at = refused.error().message.find(needs);
  ASSERT_NE(at, std::string::npos);
  const double mebibytes = std::stod(refused.error().message.substr(at + needs.size()));
  settings.device_memory_bytes = static_cast<uint64_t>((mebibytes + 0.1) * 0x1p20);
  const RenderOutcome paged = outcome_on(tested_device(), *world, settings);
  EXPECT_GT(paged.statistics.device.tiles.evicted, 0U);
  EXPECT_LE(paged.statistics.device.peak_bytes, *settings.device_memory_bytes);
  settings.device_memory_bytes.reset();
  const RenderOutcome expected = outcome_on(DeviceKind::cpu, *world, settings);
  EXPECT_GT(expected.statistics.rays.photon, 0U);
  expect_same_bits(paged.film, expected.film, "paged textures");
}

} // namespace
} // namespace kindling::test
