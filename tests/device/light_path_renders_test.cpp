// Light paths on devices: the images of the CPU, to the bit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/guiding/guide.h"
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

const V2i kLightPathImage(75, 53);

Camera light_path_camera(const CameraLens& lens = {}) {
  SceneCamera camera;
  camera.lens = lens;
  return {camera, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kLightPathImage};
}

RenderSettings beside_light_paths(uint32_t samples, float fraction) {
  RenderSettings settings = small_render(kLightPathImage, samples);
  settings.integrator.light_paths = fraction;
  return settings;
}

RenderOutcome outcome_on(DeviceKind device, const World& world, RenderSettings settings,
                         const Camera& camera = light_path_camera(), RenderContinuity continuity = {}) {
  settings.device = device;
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr, std::move(continuity));
  EXPECT_TRUE(outcome.ok()) << outcome.error().message;
  return std::move(outcome).value();
}

bool has_light_of_light_paths(const Film& film) {
  for (const Film::ConstPlane& plane : film.planes())
    if (plane.name == "splats")
      for (size_t i = 0; i < plane.bytes.size(); ++i)
        if (i % sizeof(SplatSum) < offsetof(SplatSum, paths) && plane.bytes[i] != std::byte{0}) return true;
  return false;
}

void expect_same_beside_light_paths(const World& world, const RenderSettings& settings,
                                    const Camera& camera = light_path_camera()) {
  const RenderOutcome expected = outcome_on(DeviceKind::cpu, world, settings, camera);
  EXPECT_TRUE(has_light_of_light_paths(expected.film)) << "nothing is tested";
  const RenderOutcome found = outcome_on(tested_device(), world, settings, camera);
  expect_same_bits(found.film, expected.film, "the host device");
  const RayCounters &there = found.statistics.rays, &here = expected.statistics.rays;
  EXPECT_EQ(there.paths, here.paths);
  EXPECT_EQ(there.camera, here.camera);
  EXPECT_EQ(there.bounce, here.bounce);
  EXPECT_EQ(there.shadow, here.shadow);
}

TEST(LightPathsOnDevices, AllCastersAndLights) {
  for (const bool cut_out : {false, true})
    for (const float fraction : {0.3f, 1.0f}) {
      SCOPED_TRACE(std::to_string(fraction) + (cut_out ? ", coverage and thin walls" : ", all opaque"));
      const auto world = caster_world(cut_out);
      ASSERT_EQ(world->filters_hits, cut_out);
      expect_same_beside_light_paths(*world, beside_light_paths(7, fraction));
    }
}

TEST(LightPathsOnDevices, AllMaterialsAndAovs) {
  RenderSettings settings = beside_light_paths(5, 0.5f);
  for (const AovInfo& info : kAovs)
    if (!is_light_pass(info.aov) && !is_motion(info.aov) && info.aov != Aov::shadow_catcher &&
        info.aov != Aov::direct && info.aov != Aov::indirect)
      settings.aovs.insert(info.aov);
  expect_same_beside_light_paths(*mixed_world(accel::Kind::kdtree), settings);
}

TEST(LightPathsOnDevices, LensesFiltersAndOrthographicCameras) {
  const auto world = caster_world(false);
  const CameraLens lens{.f_stop = 0.5f, .focal_length_m = 0.1f, .focus_distance_m = 5.0f, .aperture_blades = 5};
  RenderSettings settings = beside_light_paths(4, 0.5f);
  for (const FilterKind kind : {FilterKind::box, FilterKind::mitchell}) {
    settings.filter = PixelFilter({.kind = kind});
    expect_same_beside_light_paths(*world, settings, light_path_camera(lens));
    expect_same_beside_light_paths(*world, settings, beam_camera(V3f(0, 4, 4), V3f(0.0f), 6.0f, kLightPathImage));
  }
}

TEST(LightPathsOnDevices, Guiding) {
  RenderSettings settings = beside_light_paths(8, 0.25f);
  settings.planned_samples = 64;
  settings.guiding = Guiding::on;
  expect_same_beside_light_paths(*caster_world(true), settings);
}

TEST(LightPathsOnDevices, CropsSampleRangesAndAdaptiveSampling) {
  const auto world = caster_world(true);
  RenderSettings settings = beside_light_paths(9, 0.4f);
  settings.crop = PixelRect{V2i(13, 9), V2i(50, 41)};
  settings.samples = SampleRange{3, 8};
  expect_same_beside_light_paths(*world, settings);
  RenderSettings adaptive = beside_light_paths(60, 0.25f);
  adaptive.adaptive = {.noise_threshold = 0.1, .min_samples_per_pixel = 20};
  adaptive.aovs.insert(Aov::samples);
  expect_same_beside_light_paths(*world, adaptive);
}

// With sample rates a pixel may have more light paths than samples: more than a wave has places
// for.
TEST(LightPathsOnDevices, SampleRatesInSmallWaves) {
  const auto world = caster_world(false);
  RenderSettings settings = beside_light_paths(24, 1.0f);
  settings.sample_rates = SampleRateKind::noise;
  settings.min_rates_gain = 0.0;
  settings.aovs.insert(Aov::samples);
  const uint64_t scene_bytes = outcome_on(tested_device(), *world, settings).statistics.device.scene_bytes;
  expect_same_beside_light_paths(*world, settings);
  settings.device_memory_bytes = scene_bytes + (8U << 20U);
  EXPECT_LT(outcome_on(tested_device(), *world, settings).statistics.device.wave_paths, 16384U);
  expect_same_beside_light_paths(*world, settings);
}

TEST(LightPathsOnDevices, ScenesWithoutCasters) {
  const auto world = make_world(sphere_lamp_and_veil(0.6f), accel::Kind::kdtree);
  const RenderSettings settings = beside_light_paths(3, 0.5f);
  expect_same_bits(outcome_on(tested_device(), *world, settings).film,
                   outcome_on(DeviceKind::cpu, *world, settings).film, "no casters");
}

// Light of one part reaches pixels of others, whichever device renders them.
TEST(LightPathsOnDevices, PartsOfDifferentDevicesAddUp) {
  const auto world = caster_world(true);
  expect_parts_of_devices_add_up(
      beside_light_paths(9, 0.4f), {{5, 9}, {0, 2}, {2, 5}},
      [&](DeviceKind device, const RenderSettings& settings) { return outcome_on(device, *world, settings).film; });
}

TEST(LightPathsOnDevices, ResumeWhereAnotherDeviceStopped) {
  const auto world = caster_world(true);
  const Film expected = outcome_on(DeviceKind::cpu, *world, beside_light_paths(8, 0.4f)).film;
  for (const DeviceKind first : {DeviceKind::cpu, tested_device()}) {
    RenderSettings settings = beside_light_paths(4, 0.4f);
    settings.planned_samples = 8;
    std::optional<RenderState> saved;
    (void)outcome_on(first, *world, settings, light_path_camera(),
                     {.save = [&](const RenderState& state) { saved.emplace(state); }});
    ASSERT_TRUE(saved);
    settings.samples_per_pixel = 8;
    const DeviceKind second = first == DeviceKind::cpu ? tested_device() : DeviceKind::cpu;
    expect_same_bits(outcome_on(second, *world, settings, light_path_camera(), {.resume_from = std::move(saved)}).film,
                     expected, std::string(device_kind_name(first)) + " first");
  }
}

// The floor is coated, so light paths begin on twelve textures and meet others.
TEST(LightPathsOnDevices, TexturesLargerThanTheMemory) {
  const auto world = textured_world();
  RenderSettings settings = beside_light_paths(3, 1.0f);
  settings.planned_samples = 256; // for small footprints
  const RenderOutcome expected = outcome_on(DeviceKind::cpu, *world, settings);
  ASSERT_TRUE(has_light_of_light_paths(expected.film));
  uint64_t too_little = 0, enough = uint64_t{1} << 28U;
  while (enough - too_little > 65536) {
    RenderSettings one = settings;
    one.device = tested_device();
    one.samples = SampleRange{0, 1};
    one.crop = PixelRect{V2i(0), V2i(1)};
    one.device_memory_bytes = (too_little + enough) / 2;
    const bool fits = render(*world, light_path_camera(), one, nullptr, nullptr).ok();
    (fits ? enough : too_little) = *one.device_memory_bytes;
  }
  for (const uint64_t more : {1U << 18U, 0U}) {
    settings.device_memory_bytes = enough + more;
    const RenderOutcome paged = outcome_on(tested_device(), *world, settings);
    EXPECT_GT(paged.statistics.device.tiles.evicted, 0U);
    EXPECT_LE(paged.statistics.device.peak_bytes, *settings.device_memory_bytes);
    expect_same_bits(paged.film, expected.film, std::to_string(paged.statistics.device.tiles.slots) + " slots");
    EXPECT_EQ(paged.statistics.rays.total(), expected.statistics.rays.total());
  }
}

} // namespace
} // namespace kindling::test
