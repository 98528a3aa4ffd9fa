// Renders whose textures are larger than the device's memory: the images of the CPU, to the bit.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/device_plan.h"
#include "renderer/session/render_session.h"
#include "tests/device/tested_device.h"
#include "tests/device/textured_scene.h"
#include "tests/session/same_bits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kindling::test {
namespace {

const V2i kPagedSize(60, 44);

Camera paged_camera() { return {SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kPagedSize}; }

// A render whose footprints are small, so that it reads many tiles.
RenderSettings fine_render(uint32_t samples) {
  RenderSettings settings = small_render(kPagedSize, samples);
  settings.planned_samples = 256;
  return settings;
}

RenderSettings paged_settings(uint32_t samples, IntegratorKind kind) {
  RenderSettings settings = fine_render(samples);
  settings.integrator.kind = kind;
  for (const AovInfo& info : kAovs)
    if (!is_light_pass(info.aov) && !is_motion(info.aov) && info.aov != Aov::shadow_catcher)
      settings.aovs.insert(info.aov);
  return settings;
}

Result<RenderOutcome> render_within(const World& world, RenderSettings settings, std::optional<uint64_t> bytes) {
  settings.device = tested_device();
  settings.device_memory_bytes = bytes;
  return render(world, paged_camera(), settings, nullptr, nullptr);
}

// Returns the minimum of memory that a render takes.
uint64_t min_memory(const World& world, const RenderSettings& settings) {
  uint64_t too_little = 0, enough = uint64_t{1} << 30;
  RenderSettings one = settings;
  one.adaptive = {}; // takes no memory of the device
  one.samples = SampleRange{0, 1};
  one.crop = PixelRect{V2i(0), V2i(1)};
  while (enough - too_little > 4096) {
    const uint64_t middle = (too_little + enough) / 2;
    (render_within(world, one, middle).ok() ? enough : too_little) = middle;
  }
  EXPECT_GT(too_little, 0U);
  EXPECT_LT(enough, uint64_t{1} << 29);
  return enough;
}

class PagedRenders : public testing::Test {
 protected:
  // Renders with pools of all sizes; the images must be those of the CPU, within the memory.
  void expect_same_with_any_pool(const RenderSettings& settings) {
    SCOPED_TRACE(std::string(integrator_name(settings.integrator.kind)));
    const RenderOutcome expected = render(*world_, paged_camera(), settings, nullptr, nullptr).value();
    const uint64_t min_bytes = min_memory(*world_, settings);
    uint64_t loaded = 0;
    for (const uint64_t more : {1U << 20U, 1U << 18U, 0U}) {
      Result<RenderOutcome> paged = render_within(*world_, settings, min_bytes + more);
      ASSERT_TRUE(paged.ok()) << paged.error().message;
      const DeviceUse& use = paged.value().statistics.device;
      expect_same_bits(paged.value().film, expected.film, std::to_string(use.tiles.slots) + " slots");
      EXPECT_EQ(paged.value().statistics.rays.total(), expected.statistics.rays.total());
      EXPECT_LE(use.peak_bytes, min_bytes + more);
      EXPECT_GT(use.tiles.evicted, 0U);
      EXPECT_GE(use.tiles.slots, use.tiles.min_slots);
      EXPECT_LT(use.tiles.slots, use.tiles.tiles);
      EXPECT_GT(use.tiles.stages_again, 0U);
      EXPECT_GT(use.tiles.loaded, loaded);
      loaded = use.tiles.loaded;
      if (more == 0) {
        EXPECT_EQ(use.tiles.slots, use.tiles.min_slots);
      }
    }
  }

  std::unique_ptr<const World> world_ = textured_world();
};

TEST_F(PagedRenders, PathTracer) { expect_same_with_any_pool(paged_settings(3, IntegratorKind::path)); }

TEST_F(PagedRenders, WhittedTracer) {
  RenderSettings settings = paged_settings(1, IntegratorKind::whitted);
  settings.integrator.whitted.light_strata = settings.integrator.whitted.glossy_strata = 2;
  expect_same_with_any_pool(settings);
}

TEST_F(PagedRenders, AmbientOcclusionAndDebugViews) {
  for (const IntegratorKind kind : {IntegratorKind::ambient_occlusion, IntegratorKind::albedo}) {
    RenderSettings settings = fine_render(2);
    settings.integrator.kind = kind;
    expect_same_with_any_pool(settings);
  }
}

TEST_F(PagedRenders, AdaptiveSamplingTrimmingAndRates) {
  RenderSettings settings = fine_render(40);
  settings.adaptive = {.noise_threshold = 0.3, .min_samples_per_pixel = 16};
  settings.outliers = Outliers::trim;
  settings.aovs.insert(Aov::samples);
  expect_same_with_any_pool(settings);
  RenderSettings rates = fine_render(6);
  rates.sample_rates = SampleRateKind::noise;
  rates.min_rates_gain = 0.0;
  expect_same_with_any_pool(rates);
}

TEST_F(PagedRenders, TexelsStayInMemoryWhereTheyFit) {
  const RenderSettings settings = fine_render(1);
  const Result<RenderOutcome> unlimited = render_within(*world_, settings, std::nullopt);
  ASSERT_TRUE(unlimited.ok());
  const DeviceUse& use = unlimited.value().statistics.device;
  EXPECT_EQ(use.tiles.tiles, 0U);
  EXPECT_EQ(use.wave_paths, kWaveSize);
  // Smaller waves come before paging.
  const Result<RenderOutcome> tight = render_within(*world_, settings, use.scene_bytes + (200U << 20));
  ASSERT_TRUE(tight.ok());
  EXPECT_EQ(tight.value().statistics.device.tiles.tiles, 0U);
  EXPECT_LT(tight.value().statistics.device.wave_paths, kWaveSize);
  EXPECT_LE(tight.value().statistics.device.peak_bytes, use.scene_bytes + (200U << 20));
  expect_same_bits(tight.value().film, unlimited.value().film, "smaller waves");
}

TEST_F(PagedRenders, TooLittleMemoryIsRefusedWithFigures) {
  const RenderSettings settings = fine_render(1);
  const uint64_t min_bytes = min_memory(*world_, settings);
  const Result<RenderOutcome> refused = render_within(*world_, settings, min_bytes - 8192);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::render_failed);
  const std::string& message = refused.error().message;
  for (const char* part : {": no room for the scene: it needs at least ", " MiB (scene ", ", waves ",
                           ", texture tiles ", " are free; use --device cpu or a larger --device-memory"})
    EXPECT_NE(message.find(part), std::string::npos) << message;
  const double needed = std::atof(message.c_str() + message.find("at least ") + 9);
  EXPECT_NEAR(needed, static_cast<double>(min_bytes) * 0x1p-20, 0.1);
}

// Geometry is never paged.
TEST_F(PagedRenders, ScenesWithoutTexturesNeedAllTheirMemory) {
  const auto plain = make_world(sphere_lamp_and_veil(0.3f), accel::Kind::kdtree);
  const RenderSettings settings = fine_render(1);
  const uint64_t min_bytes = min_memory(*plain, settings);
  const Result<RenderOutcome> fits = render_within(*plain, settings, min_bytes);
  ASSERT_TRUE(fits.ok()) << fits.error().message;
  EXPECT_EQ(fits.value().statistics.device.tiles.tiles, 0U);
  EXPECT_EQ(fits.value().statistics.device.wave_paths, kMinWaveSize);
  const Result<RenderOutcome> refused = render_within(*plain, settings, min_bytes - 8192);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message.find("tiles"), std::string::npos) << refused.error().message;
}

} // namespace
} // namespace kindling::test
