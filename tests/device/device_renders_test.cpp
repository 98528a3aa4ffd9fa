// The host device renders the images of the CPU, to the bit, for all settings.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/kernels/path_wave.h"
#include "renderer/integrator/frame_motion.h"
#include "renderer/session/render_session.h"
#include "tests/device/caster_scene.h"
#include "tests/device/tested_device.h"
#include "tests/integrator/glass_bell.h"
#include "tests/integrator/wax_scene.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

namespace kindling::test {
namespace {

const V2i kSize(75, 53); // not a multiple of anything

Camera camera_with(const CameraLens& lens = {}, const V2i& size_px = kSize) {
  SceneCamera camera;
  camera.lens = lens;
  return {camera, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), size_px};
}

RenderSettings all_aovs(uint32_t samples) {
  RenderSettings settings = small_render(kSize, samples);
  for (const AovInfo& info : kAovs)
    if (!is_light_pass(info.aov) && !is_motion(info.aov) && info.aov != Aov::shadow_catcher)
      settings.aovs.insert(info.aov);
  return settings;
}

Film film_of(const World& world, const Camera& camera, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << outcome.error().message;
  return std::move(outcome).value().film;
}

void expect_same_on_device(const World& world, RenderSettings settings, const Camera& camera = camera_with()) {
  if (settings.integrator.kind != IntegratorKind::whitted) add_mattes(settings);
  const Film reference = film_of(world, camera, settings);
  RenderSettings on_device = settings;
  on_device.device = tested_device();
  on_device.threads = 2;
  expect_same_bits(film_of(world, camera, on_device), reference, "the host device");
}

TEST(DeviceRenders, AllMaterialsAndAovs) { expect_same_on_device(*mixed_world(accel::Kind::kdtree), all_aovs(7)); }

TEST(DeviceRenders, Motion) {
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSize, {.shutter_open = true});
  expect_same_on_device(*moving_world(accel::Kind::kdtree), all_aovs(5), camera);
}

TEST(DeviceRenders, MotionVectors) {
  const auto beside = [](float x) { return Camera(SceneCamera{}, look_at(V3f(x, 1.2f, 6), V3f(0.0f)), kSize); };
  RenderSettings settings = all_aovs(5);
  settings.motion = std::make_shared<const FrameMotion>(FrameMotion{{{}, beside(1.4f)}, {{}, beside(1.7f)}});
  settings.aovs.insert(Aov::vector);
  settings.aovs.insert(Aov::motion);
  expect_same_on_device(*mixed_world(accel::Kind::kdtree), settings);
}

TEST(DeviceRenders, DepthOfField) {
  const CameraLens lens{
      .f_stop = 0.5f, .focal_length_m = 0.1f, .focus_distance_m = 5.0f, .aperture_blades = 5, .cats_eye = 0.5f};
  expect_same_on_device(*mixed_world(accel::Kind::kdtree), all_aovs(5), camera_with(lens));
}

TEST(DeviceRenders, SamplersAndFilters) {
  const auto world = mixed_world(accel::Kind::kdtree);
  for (const SamplerKind sampler : {SamplerKind::sobol, SamplerKind::independent, SamplerKind::jittered}) {
    RenderSettings settings = small_render(kSize, 4);
    settings.sampler = sampler;
    settings.filter = PixelFilter({.kind = FilterKind::mitchell});
    expect_same_on_device(*world, settings);
  }
}

TEST(DeviceRenders, ClampsCausticsAndTrimming) {
  const auto world = mixed_world(accel::Kind::kdtree);
  for (const Caustics caustics : {Caustics::regularized, Caustics::off}) {
    RenderSettings settings = all_aovs(11);
    settings.integrator.caustics = caustics;
    settings.integrator.clamp_indirect = 0.5f;
    settings.outliers = Outliers::trim;
    expect_same_on_device(*world, settings);
  }
}

TEST(DeviceRenders, SeveralLightSamples) {
  RenderSettings settings = all_aovs(5);
  settings.integrator.direct_samples = 3;
  expect_same_on_device(*mixed_world(accel::Kind::kdtree), settings);
  expect_same_on_device(*caster_world(false), settings);
}

TEST(DeviceRenders, ReflectionSamples) {
  for (const bool several : {false, true}) {
    RenderSettings settings = all_aovs(5);
    settings.integrator.direct_samples = several ? 3 : 1;
    settings.integrator.reflection_samples = several ? 4 : 1;
    settings.integrator.path_reuse = several ? 4 : 1;
    expect_same_on_device(*mixed_world(accel::Kind::kdtree), settings);
    expect_same_on_device(*caster_world(false), settings);
  }
}

// Where all is opaque, each shadow ray has a thread; another one adds the light of a path's rays.
// One sample is always one pass; how many samples later passes have depends on the machine's speed.
TEST(DeviceRenders, PathsAreSortedByMaterialWhereThereAreMany) {
  const auto world = caster_world(false);
  const auto use_of = [&](const V2i& size_px, int direct_samples) {
    RenderSettings settings = small_render(size_px, 1);
    settings.integrator.direct_samples = direct_samples;
    settings.device = tested_device();
    Result<RenderOutcome> outcome = render(*world, camera_with({}, size_px), settings, nullptr, nullptr);
    EXPECT_TRUE(outcome.ok()) << outcome.error().message;
    const RenderStatistics& statistics = outcome.value().statistics;
    const auto of = [&](Kernel kernel) { return statistics.device.kernels[static_cast<size_t>(kernel)]; };
    EXPECT_EQ(of(Kernel::begin_path).threads, statistics.rays.paths);
    EXPECT_EQ(of(Kernel::add_shadows).launches > 0, direct_samples > 1);
    EXPECT_EQ(of(Kernel::place_kinds).threads, of(Kernel::sort_paths).launches * kHitKinds);
    EXPECT_GT(of(Kernel::shade).seconds, 0.0);
    return of(Kernel::sort_paths);
  };
  const KernelUse few = use_of(kSize, 1), many = use_of(V2i(240, 170), 3);
  EXPECT_EQ(few.launches, 0U);
  EXPECT_GT(many.launches, 0U);
  EXPECT_GE(many.threads, many.launches * 8192);
}

TEST(DeviceRenders, PathReuse) {
  for (const bool opaque : {false, true})
    for (const int paths : {2, 8}) {
      RenderSettings settings = all_aovs(5);
      settings.integrator.path_reuse = paths;
      settings.integrator.direct_samples = 2;
      expect_same_on_device(*(opaque ? caster_world(false) : mixed_world(accel::Kind::kdtree)), settings);
      settings.crop = PixelRect{V2i(3, 5), V2i(21, 10)};
      expect_same_on_device(*(opaque ? caster_world(false) : mixed_world(accel::Kind::kdtree)), settings);
    }
}

TEST(DeviceRenders, GuidingAndPathReuse) {
  RenderSettings settings = small_render(kSize, 64);
  settings.guiding = Guiding::on;
  settings.integrator.path_reuse = 4;
  expect_same_on_device(*mixed_world(accel::Kind::kdtree), settings);
}

TEST(DeviceRenders, Guiding) {
  RenderSettings settings = small_render(kSize, 64);
  settings.guiding = Guiding::on;
  expect_same_on_device(*mixed_world(accel::Kind::kdtree), settings);
}

// The guide of the render must have some of these regions, or nothing is tested.
void expect_same_guided(const World& world, Guiding guiding, uint64_t training_paths, const Camera& camera,
                        int GuidingStatistics::*regions) {
  RenderSettings settings = small_render(kSize, 8);
  settings.guiding = guiding;
  settings.training_paths = training_paths;
  const Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  ASSERT_TRUE(outcome.ok());
  EXPECT_GT(outcome.value().statistics.guiding.*regions, 0) << "no guide, so nothing is tested";
  expect_same_on_device(world, settings, camera);
}

TEST(DeviceRenders, GuidedScattering) {
  const auto world = make_world(wax_under_a_lamp(wax(0.2f, Rgb(0.8f, 0.5f, 0.4f))), accel::Kind::kdtree);
  expect_same_guided(*world, Guiding::automatic, 20000, wax_camera(kSize), &GuidingStatistics::volume_regions);
}

TEST(DeviceRenders, GuidingToCaustics) {
  const Camera camera(SceneCamera{}, look_at(V3f(0, 1.5f, 6), V3f(0.0f)), kSize);
  expect_same_guided(*caster_world(false), Guiding::on, 20000, camera, &GuidingStatistics::caustic_regions);
}

TEST(DeviceRenders, GuidingByTheEnvironment) {
  expect_same_guided(*bell_world(), Guiding::automatic, 60000, bell_camera(kSize),
                     &GuidingStatistics::environment_regions);
}

// The second of the two samples is beyond those that read the table.
TEST(DeviceRenders, PresampledEnvironment) {
  constexpr uint32_t kMaxSamples = PresampledEnvironmentView::kMaxSamples;
  RenderSettings settings = small_render(kSize, kMaxSamples + 1);
  settings.samples = SampleRange{kMaxSamples - 1, kMaxSamples + 1};
  settings.integrator.direct_samples = 2;
  expect_same_on_device(*bell_world(), settings, bell_camera(kSize));
}

TEST(DeviceRenders, WhittedTrees) {
  for (const int strata : {1, 3}) {
    RenderSettings settings = all_aovs(3);
    settings.integrator.kind = IntegratorKind::whitted;
    settings.integrator.whitted.glossy_strata = settings.integrator.whitted.light_strata = strata;
    settings.integrator.transparent_background = strata > 1;
    expect_same_on_device(*mixed_world(accel::Kind::kdtree), settings);
    const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kSize, {.shutter_open = true});
    expect_same_on_device(*moving_world(accel::Kind::kdtree), settings, camera);
  }
}

TEST(DeviceRenders, AmbientOcclusionAndDebugViews) {
  const auto world = mixed_world(accel::Kind::kdtree);
  for (const IntegratorKind kind : all_integrators()) {
    SCOPED_TRACE(integrator_name(kind));
    RenderSettings settings = small_render(kSize, 3);
    settings.integrator.kind = kind;
    settings.outliers = Outliers::trim;
    settings.aovs.insert(Aov::variance);
    expect_same_on_device(*world, settings);
  }
}

TEST(DeviceRenders, CropsAndSampleRanges) {
  const auto world = mixed_world(accel::Kind::kdtree);
  RenderSettings settings = all_aovs(9);
  settings.crop = PixelRect{V2i(13, 9), V2i(50, 41)};
  settings.samples = SampleRange{3, 8};
  expect_same_on_device(*world, settings);
}

// Decisions depend on the rays of each block, which the device counts too.
TEST(DeviceRenders, AdaptiveSampling) {
  RenderSettings settings = small_render(kSize, 100);
  settings.adaptive = {.noise_threshold = 0.06, .min_samples_per_pixel = 20};
  settings.aovs.insert(Aov::samples);
  expect_same_on_device(*mixed_world(accel::Kind::kdtree), settings);
}

TEST(DeviceRenders, CountsTheSameRays) {
  const auto world = mixed_world(accel::Kind::kdtree);
  for (const IntegratorKind kind : {IntegratorKind::path, IntegratorKind::whitted, IntegratorKind::ambient_occlusion}) {
    RenderSettings settings = small_render(kSize, 3);
    settings.integrator.kind = kind;
    const auto rays_on = [&](DeviceKind device) {
      settings.device = device;
      return render(*world, camera_with(), settings, nullptr, nullptr).value().statistics.rays;
    };
    const RayCounters cpu = rays_on(DeviceKind::cpu), host = rays_on(tested_device());
    EXPECT_EQ(host.camera, cpu.camera);
    EXPECT_EQ(host.bounce, cpu.bounce);
    EXPECT_EQ(host.shadow, cpu.shadow);
    EXPECT_EQ(host.paths, cpu.paths);
    EXPECT_EQ(host.whitted.reflection, cpu.whitted.reflection);
    EXPECT_EQ(host.whitted.transmission, cpu.whitted.transmission);
  }
}

// Half of the samples by one device and the rest by the other: saved in between, and resumed.
TEST(DeviceRenders, ResumeWhereAnotherDeviceStopped) {
  const auto world = mixed_world(accel::Kind::kdtree);
  const Film reference = film_of(*world, camera_with(), all_aovs(8));
  for (const DeviceKind first : {DeviceKind::cpu, tested_device()}) {
    RenderSettings settings = all_aovs(4);
    settings.planned_samples = 8;
    settings.device = first;
    std::optional<RenderState> saved;
    ASSERT_TRUE(render(*world, camera_with(), settings, nullptr, nullptr,
                       {.save = [&](const RenderState& state) { saved.emplace(state); }}));
    ASSERT_TRUE(saved);
    settings.samples_per_pixel = 8;
    settings.device = first == DeviceKind::cpu ? tested_device() : DeviceKind::cpu;
    Result<RenderOutcome> whole =
        render(*world, camera_with(), settings, nullptr, nullptr, {.resume_from = std::move(saved)});
    ASSERT_TRUE(whole);
    expect_same_bits(whole.value().film, reference, std::string(device_kind_name(first)) + " first");
  }
}

TEST(DeviceRenders, RefuseAcceleratorsWithoutATree) {
  RenderSettings settings = small_render(kSize, 1);
  settings.device = tested_device();
  const Result<RenderOutcome> embree =
      render(*mixed_world(accel::Kind::embree), camera_with(), settings, nullptr, nullptr);
  ASSERT_FALSE(embree);
  EXPECT_EQ(embree.error().kind, ErrorKind::usage);
  EXPECT_NE(embree.error().message.find("--accel kdtree"), std::string::npos) << embree.error().message;
}

} // namespace
} // namespace kindling::test
