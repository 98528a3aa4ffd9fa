// A device's memory: scenes that need nothing else, and waves within their estimate.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/first_hit_wave_runner.h"
#include "renderer/device/host_device.h"
#include "renderer/device/path_wave_runner.h"
#include "renderer/device/scene_on_device.h"
#include "renderer/device/tree_wave_runner.h"
#include "renderer/integrator/light_paths/light_paths.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/integrator/stages/first_hit.h"
#include "renderer/light/per_light_sampling.h"
#include "renderer/session/prepare/train_guide.h"
#include "renderer/session/render_session.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <malloc.h>

namespace kindling::test {
namespace {

// All blocks of an image, with the same samples.
std::vector<BlockWork> all_blocks(const V2i& size, const SampleRange& samples) {
  std::vector<BlockWork> work;
  for (int y = 0; y < size.y; y += kBlockSize)
    for (int x = 0; x < size.x; x += kBlockSize)
      work.push_back({{V2i(x, y), V2i(std::min(x + kBlockSize, size.x), std::min(y + kBlockSize, size.y))}, samples});
  return work;
}

// The scene is rendered from its copy after the world, the camera and the guide are gone, and freed
// memory is overwritten.
TEST(DeviceMemory, CopyOfASceneNeedsNothingElse) {
  mallopt(M_PERTURB, 0x5a);
  const V2i size(40, 24);
  const SampleRange samples{0, 6};
  for (const bool moving : {false, true}) {
    const auto make_world = [&] {
      return moving ? moving_world(accel::Kind::kdtree) : mixed_world(accel::Kind::kdtree);
    };
    for (const IntegratorKind kind : {IntegratorKind::path, IntegratorKind::whitted, IntegratorKind::normal}) {
      SCOPED_TRACE(std::string(integrator_name(kind)) + (moving ? ", moving" : ""));
      RenderSettings settings = small_render(size, 64);
      settings.guiding = Guiding::on;
      settings.samples = samples;
      settings.integrator.kind = kind;
      if (kind == IntegratorKind::path && !moving) settings.integrator.light_paths = 0.5f;
      const std::unique_ptr<Device> device = make_host_device(2);
      const WaveSetup setup{.paths = device->wave_size(), .light_paths = settings.integrator.light_paths};
      std::optional<SceneOnDevice> scene;
      std::optional<Film> expected;
      {
        const std::unique_ptr<const World> world = make_world();
        const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), size, {.shutter_open = moving});
        const TrainedGuide trained = train_guide(*world, camera, settings, nullptr, {});
        const Sampler sampler(settings.seed, settings.sampler, settings.planned());
        const PerLightSampling lights(world->light_set());
        PathStages stages = make_path_stages(settings.integrator, *world, camera, sampler, trained.guide.get());
        const std::unique_ptr<LightPaths> light_paths =
            make_light_paths(settings.integrator, *world, camera, settings.filter, sampler.seed());
        ASSERT_EQ(light_paths != nullptr, setup.light_paths > 0.0f);
        stages.light_paths = light_paths.get();
        const std::unique_ptr<const PresampledEnvironment> presampled =
            presample_environment(settings.integrator, world->lights, sampler.seed());
        stages.presampled = presampled.get();
        const WhittedShader shader = make_whitted_shader(settings.integrator, *world, camera, sampler, lights);
        const FirstHitStages first_hit = make_first_hit_stages(settings.integrator, *world, camera, sampler);
        scene.emplace(*device, DeviceSceneInput{*world, camera, stages, shader, first_hit, sampler, settings.filter,
                                                light_paths.get()});
        expected.emplace(render(*world, camera, settings, nullptr, nullptr).value().film);
      }
      const std::unique_ptr<const World> other = make_world(); // asked whether the render is abandoned
      std::unique_ptr<DeviceWave> wave;
      if (kind == IntegratorKind::path)
        wave = std::make_unique<PathWaveRunner>(*device, *other, scene->address(), setup);
      else if (kind == IntegratorKind::whitted)
        wave = std::make_unique<TreeWaveRunner>(*device, *other, scene->address(), settings.integrator.whitted, setup);
      else
        wave = std::make_unique<FirstHitWaveRunner>(*device, *other, scene->address(), setup);
      std::vector<BlockWork> work = all_blocks(size, samples);
      for (size_t i = 0; i < work.size(); ++i) ASSERT_EQ(wave->take(i, work[i].block, samples), samples.count());
      Film film(size, {V2i(0), size}, settings.aovs);
      if (setup.light_paths > 0.0f) film.enable_splats();
      ASSERT_TRUE(wave->run(film));
      wave->take_results(work, film);
      expect_same_bits(film, *expected, "the copy");
    }
  }
  mallopt(M_PERTURB, 0);
}

// A device that counts the bytes it is asked for, and computes nothing.
class CountingDevice final : public Device {
 public:
  [[nodiscard]] std::string name() const override { return "counting"; }
  [[nodiscard]] std::byte* allocate(size_t bytes) override {
    allocated += bytes;
    return host_->allocate(bytes);
  }
  void release(std::byte* memory) noexcept override { host_->release(memory); }
  void upload(std::span<const std::byte> from, std::byte* to) override { host_->upload(from, to); }
  void download(const std::byte* from, std::span<std::byte> to) override { host_->download(from, to); }
  void clear(std::byte* memory, size_t bytes) override { host_->clear(memory, bytes); }
  void launch(Kernel /*kernel*/, std::span<const std::byte> /*argument*/, uint32_t /*count*/) override {}
  [[nodiscard]] uint32_t wave_size() const override { return kPaths; }

  static constexpr uint32_t kPaths = 4096;
  uint64_t allocated = 0;

 private:
  std::unique_ptr<Device> host_ = make_host_device(1);
};

// Runs a wave of one sample for each pixel, which fills it. Returns the bytes that it took.
template <typename Wave, typename... Arguments>
uint64_t bytes_of_wave(const WaveSetup& setup, const World& world, const Arguments&... arguments) {
  CountingDevice device;
  Wave wave(device, world, nullptr, arguments..., setup);
  const V2i size(64, 64);
  Film film(size, {V2i(0), size}, setup.aovs);
  if (setup.trims_outliers) film.trim_outliers();
  film.split_by_light_groups(std::vector<std::string>(setup.light_groups));
  for (int y = 0; y < 64; y += 8)
    for (int x = 0; x < 64; x += 8) EXPECT_EQ(wave.take(0, {V2i(x, y), V2i(x + 8, y + 8)}, {0, 1}), 1U);
  if constexpr (!std::is_same_v<Wave, TreeWaveRunner>) {
    EXPECT_TRUE(wave.run(film));
  }
  return device.allocated;
}

TEST(DeviceMemory, WavesTakeTheirEstimate) {
  const std::unique_ptr<const World> world = mixed_world(accel::Kind::kdtree);
  constexpr uint64_t kUnusedBlocks = CountingDevice::kPaths * (sizeof(WaveBlock) + sizeof(WaveRays<uint64_t>));
  WaveSetup setup{.paths = CountingDevice::kPaths};
  for (const AovInfo& info : kAovs) { // one more each time
    setup.aovs.insert(info.aov);
    setup.trims_outliers = !setup.trims_outliers;
    setup.light_paths = setup.trims_outliers ? 0.0f : 1.0f;
    setup.light_groups = setup.trims_outliers ? 0 : 3;
    const uint64_t of_paths = bytes_of_wave<PathWaveRunner>(setup, *world);
    EXPECT_LE(of_paths, path_wave_bytes(setup));
    EXPECT_GE(of_paths, path_wave_bytes(setup) - kUnusedBlocks);
    const uint64_t of_first_hits = bytes_of_wave<FirstHitWaveRunner>(setup, *world);
    EXPECT_LE(of_first_hits, first_hit_wave_bytes(setup));
    const WhittedSettings whitted;
    const uint64_t of_trees = bytes_of_wave<TreeWaveRunner>(setup, *world, whitted); // before it runs
    EXPECT_LE(of_trees, tree_wave_bytes(setup, whitted));
    EXPECT_GE(of_trees, tree_wave_bytes(setup, whitted) - common_wave_bytes(setup));
  }
}

} // namespace
} // namespace kindling::test
