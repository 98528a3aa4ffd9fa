// Renders on a GPU whose driver is a stand-in: its images, its failures, and what it leaves behind.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/cuda_device.h"
#include "renderer/device/cuda/kernel_cache.h"
#include "renderer/device/kernels/all_kernels.h"
#include "renderer/session/render_session.h"
#include "tests/device/caster_scene.h"
#include "tests/device/textured_scene.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kindling::test {
namespace {

const V2i kGpuImage(40, 28);

Camera gpu_camera() { return {SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kGpuImage}; }

int run_kernel(const char* name, const void* argument, unsigned count, unsigned /*threads_per_block*/) {
#define KINDLING_RUN_NAMED(kernel, type)                                                                               \
  if (std::strcmp(name, "kindling_" #kernel) == 0)                                                                     \
    for (unsigned i = 0; i < count; ++i) kernels::kernel(*static_cast<const type*>(argument), i);
  KINDLING_KERNELS(KINDLING_RUN_NAMED)
#undef KINDLING_RUN_NAMED
  return 0;
}

class Gpu : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_gpu_kernels()) GTEST_SKIP() << "built without clang-19: there are no kernels for GPUs";
    library_ = dlopen(KINDLING_FAKE_CUDA, RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library_, nullptr) << dlerror();
    *static_cast<decltype(&run_kernel)*>(dlsym(library_, "fake_cuda_run")) = run_kernel;
    setenv("KINDLING_CUDA_DRIVER", KINDLING_FAKE_CUDA, 1);
    setenv("XDG_CACHE_HOME", cache_.c_str(), 1);
    fail("");
  }
  void TearDown() override {
    if (library_ == nullptr) return;
    EXPECT_EQ(reinterpret_cast<size_t (*)()>(dlsym(library_, "fake_cuda_allocations"))(), 0U);
    unsetenv("KINDLING_CUDA_DRIVER");
    unsetenv("FAKE_CUDA");
    unsetenv("XDG_CACHE_HOME");
    std::filesystem::remove_all(cache_);
    dlclose(library_);
  }

  static void fail(const std::string& how) { setenv("FAKE_CUDA", how.c_str(), 1); }
  static RenderSettings settings(uint32_t samples) {
    RenderSettings settings = small_render(kGpuImage, samples);
    for (const AovInfo& info : kAovs)
      if (!is_light_pass(info.aov) && !is_motion(info.aov) && info.aov != Aov::shadow_catcher)
        settings.aovs.insert(info.aov);
    settings.device = DeviceKind::gpu;
    return settings;
  }
  // Returns the message of a render that fails.
  std::string message() {
    const Result<RenderOutcome> outcome = render(*world_, gpu_camera(), settings(1), nullptr, nullptr);
    EXPECT_FALSE(outcome.ok());
    if (outcome.ok()) return {};
    EXPECT_EQ(outcome.error().kind, ErrorKind::render_failed);
    EXPECT_EQ(outcome.error().message.find('\n'), std::string::npos);
    return outcome.error().message;
  }
  // Renders, and returns how often kernels were compiled for it.
  size_t compilations() { return compilations(settings(1)); }
  size_t compilations(const RenderSettings& here) {
    const auto count = reinterpret_cast<long (*)()>(dlsym(library_, "fake_cuda_compilations"));
    const long before = count();
    EXPECT_TRUE(render(*world_, gpu_camera(), here, nullptr, nullptr).ok());
    return static_cast<size_t>(count() - before);
  }
  [[nodiscard]] std::vector<std::filesystem::path> cached() const {
    std::vector<std::filesystem::path> files;
    const std::filesystem::path folder = cache_ / "kindling/kernels";
    if (!exists(folder)) return files;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
    return files;
  }
  void expect_message(const std::string& part) { EXPECT_NE(message().find(part), std::string::npos) << message(); }

  static void expect_bits_of_cpu(const World& world, RenderSettings render_settings) {
    render_settings.device = DeviceKind::gpu;
    const Result<RenderOutcome> gpu = render(world, gpu_camera(), render_settings, nullptr, nullptr);
    ASSERT_TRUE(gpu.ok()) << gpu.error().message;
    render_settings.device = DeviceKind::cpu;
    const Result<RenderOutcome> cpu = render(world, gpu_camera(), render_settings, nullptr, nullptr);
    expect_same_bits(gpu.value().film, cpu.value().film, "the GPU's driver");
  }

  static constexpr size_t kOfPaths = 7; // kernels that a render by the path tracer needs

  std::unique_ptr<const World> world_ = mixed_world(accel::Kind::kdtree);
  const std::filesystem::path cache_ =
      std::filesystem::path(testing::TempDir()) / ("kindling_" + std::to_string(getpid()));

 private:
  void* library_ = nullptr;
};

TEST_F(Gpu, RendersTheSameImageAsTheCpu) { expect_bits_of_cpu(*world_, settings(6)); }

TEST_F(Gpu, RendersTheSameImageBesideLightPaths) {
  for (const bool cut_out : {false, true}) {
    RenderSettings beside = small_render(kGpuImage, 6);
    beside.integrator.light_paths = 0.5f;
    expect_bits_of_cpu(*caster_world(cut_out), beside);
  }
}

TEST_F(Gpu, RendersTheSameImageWithPhotons) {
  RenderSettings with_map = small_render(kGpuImage, 20);
  with_map.integrator.photons = 1.0f;
  expect_bits_of_cpu(*caster_world(true), with_map);
}

TEST_F(Gpu, EachFailureToStartHasItsMessage) {
  fail("init=100");
  expect_message("NVIDIA's driver does not start: a failure (CUDA_ERROR); use --device cpu");
  fail("version=10020");
  expect_message("supports CUDA 10.2; at least 11.0 is needed");
  fail("devices=0");
  expect_message("NVIDIA's driver knows none that can render; use --device cpu");
  fail("capability=61");
  expect_message("(Fake GPU has compute capability 6.1; at least 7.0 is needed)");
  fail("compile=218");
  expect_message("Fake GPU: compiling the kernels failed: a failure (CUDA_ERROR): line 7: unknown instruction");
  setenv("KINDLING_CUDA_DRIVER", "/nowhere/libcuda.so.1", 1);
  expect_message("NVIDIA's driver cannot be opened (/nowhere/libcuda.so.1");
  setenv("KINDLING_CUDA_DRIVER", "libm.so.6", 1);
  expect_message("libm.so.6 lacks the function cuInit");
}

// A render compiles the kernels that it launches, each by itself.
TEST_F(Gpu, KernelsAreCompiledOnceForEachDriver) {
  EXPECT_EQ(compilations(), kOfPaths);
  ASSERT_EQ(cached().size(), kOfPaths);
  EXPECT_NE(cached()[0].filename().string().find("sm_90-cuda_13000-"), std::string::npos) << cached()[0];
  EXPECT_EQ(compilations(), 0U);
  fail("version=13010");
  EXPECT_EQ(compilations(), kOfPaths);
  fail("version=13010 capability=80");
  EXPECT_EQ(compilations(), kOfPaths);
  EXPECT_EQ(cached().size(), 3 * kOfPaths);
}

TEST_F(Gpu, IntegratorsShareTheCache) {
  EXPECT_EQ(compilations(), kOfPaths);
  RenderSettings other = settings(1);
  other.aovs = {};
  other.integrator.kind = IntegratorKind::ambient_occlusion;
  EXPECT_EQ(compilations(other), 2U);
  EXPECT_EQ(compilations(other), 0U);
  EXPECT_EQ(compilations(), 0U);
  RenderSettings beside = small_render(kGpuImage, 1);
  beside.device = DeviceKind::gpu;
  beside.integrator.light_paths = 1.0f;
  EXPECT_EQ(compilations(beside), 4U); // three of light paths, and another one that shades
  beside.integrator.photons = 1.0f;
  EXPECT_EQ(compilations(beside), 3U); // two of photons, and a third one that shades
}

TEST_F(Gpu, ACompilationIsAnnounced) {
  class Warnings final : public ProgressListener {
   public:
    void on_progress(const ProgressSnapshot&) override {}
    void on_warning(std::string_view message) override { messages.emplace_back(message); }
    void on_info(std::string_view) override {}
    std::vector<std::string> messages;
  };
  Warnings first, second;
  EXPECT_TRUE(render(*world_, gpu_camera(), settings(1), nullptr, &first).ok());
  ASSERT_EQ(first.messages.size(), 1U);
  EXPECT_NE(first.messages[0].find("Fake GPU: its driver compiles 7 kernels once"), std::string::npos)
      << first.messages[0];
  EXPECT_TRUE(render(*world_, gpu_camera(), settings(1), nullptr, &second).ok());
  EXPECT_TRUE(second.messages.empty());
}

TEST_F(Gpu, DamagedKernelsAreCompiledAgain) {
  EXPECT_EQ(compilations(), kOfPaths);
  std::ofstream(cached().at(0)) << "damaged";
  std::ofstream(cached().at(1)).flush(); // empty
  std::filesystem::resize_file(cached().at(2), std::filesystem::file_size(cached().at(2)) - 1);
  EXPECT_EQ(compilations(), 3U);
  EXPECT_EQ(compilations(), 0U);
}

TEST_F(Gpu, ACacheThatCannotBeWrittenIsNoError) {
  setenv("XDG_CACHE_HOME", "/proc/nowhere", 1);
  EXPECT_EQ(compilations(), kOfPaths);
  EXPECT_EQ(compilations(), kOfPaths);
}

TEST_F(Gpu, TheCacheIsBounded) {
  for (int version = 0; version < 14; ++version) {
    fail("version=" + std::to_string(12000 + 10 * version));
    EXPECT_EQ(compilations(), kOfPaths);
  }
  EXPECT_EQ(cached().size(), kMaxCachedKernels);
}

TEST_F(Gpu, AGpuThatIsTakenIsPassedOver) {
  fail("devices=2 unavailable=1");
  EXPECT_TRUE(render(*world_, gpu_camera(), settings(1), nullptr, nullptr).ok());
  fail("devices=2 unavailable=2");
  expect_message(
      "knows none that can render (Fake GPU: starting it failed: a failure (CUDA_ERROR_DEVICE_UNAVAILABLE))");
}

TEST_F(Gpu, LackOfMemoryIsReportedWithFigures) {
  fail("memory=70000");
  expect_message("Fake GPU: no room for the scene: it needs at least ");
  expect_message(" MiB), and 0.0 MiB are free; use --device cpu");
}

// Each launch of the stand-in takes a millisecond.
TEST_F(Gpu, LaunchesAreTimed) {
  const Result<RenderOutcome> gpu = render(*world_, gpu_camera(), settings(3), nullptr, nullptr);
  ASSERT_TRUE(gpu.ok()) << gpu.error().message;
  const KernelUses& uses = gpu.value().statistics.device.kernels;
  uint64_t launches = 0;
  for (const Kernel kernel : kAllKernels) {
    const KernelUse& use = uses[static_cast<size_t>(kernel)];
    EXPECT_NEAR(use.seconds, 1e-3 * static_cast<double>(use.launches), 1e-9) << kernel_name(kernel);
    launches += use.launches;
  }
  EXPECT_EQ(uses[static_cast<size_t>(Kernel::begin_path)].threads, gpu.value().statistics.rays.paths);
  EXPECT_GT(launches, 5U);
}

TEST_F(Gpu, WavesAreSmallerWhereThereIsLittleMemory) {
  fail("memory=100000000");
  RenderSettings here = settings(6);
  Result<RenderOutcome> gpu = render(*world_, gpu_camera(), here, nullptr, nullptr);
  ASSERT_TRUE(gpu.ok()) << gpu.error().message;
  EXPECT_LT(gpu.value().statistics.device.wave_paths, kWaveSize);
  here.device = DeviceKind::cpu;
  expect_same_bits(gpu.value().film, render(*world_, gpu_camera(), here, nullptr, nullptr).value().film, "small waves");
}

TEST_F(Gpu, TexturesArePagedWhereTheyDoNotFit) {
  const std::unique_ptr<const World> textured = textured_world();
  RenderSettings here = settings(3);
  const Film expected = render(
                            *textured, gpu_camera(),
                            [&] {
                              RenderSettings on_cpu = here;
                              on_cpu.device = DeviceKind::cpu;
                              return on_cpu;
                            }(),
                            nullptr, nullptr)
                            .value()
                            .film;
  here.device_memory_bytes = 13 << 20;
  Result<RenderOutcome> gpu = render(*textured, gpu_camera(), here, nullptr, nullptr);
  ASSERT_TRUE(gpu.ok()) << gpu.error().message;
  EXPECT_GT(gpu.value().statistics.device.tiles.loaded, 0U);
  expect_same_bits(gpu.value().film, expected, "paged textures");
}

// The samples of finished waves are saved, and a resumed render has the image of one that was not
// interrupted.
TEST_F(Gpu, ALostDeviceCostsUnfinishedWavesOnly) {
  RenderSettings here = settings(16);
  here.device = DeviceKind::cpu;
  const Film whole = std::move(render(*world_, gpu_camera(), here, nullptr, nullptr)).value().film;
  here.device = DeviceKind::gpu;
  fail("lost=100");
  std::optional<RenderState> saved;
  const RenderContinuity continuity{.save = [&](const RenderState& state) { saved.emplace(state); }};
  const Result<RenderOutcome> lost = render(*world_, gpu_camera(), here, nullptr, nullptr, continuity);
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.error().message,
            "Fake GPU: starting a kernel failed: unspecified launch failure (CUDA_ERROR_LAUNCH_FAILED)");
  ASSERT_TRUE(saved);
  EXPECT_GT(saved->film.total_samples(), 0U);
  EXPECT_LT(saved->film.total_samples(), whole.total_samples());
  fail("");
  here.device = DeviceKind::cpu;
  Result<RenderOutcome> rest = render(*world_, gpu_camera(), here, nullptr, nullptr, {.resume_from = std::move(saved)});
  ASSERT_TRUE(rest.ok());
  expect_same_bits(rest.value().film, whole, "a GPU that was lost");
}

// A render with DeviceKind::automatic, and what the CPU renders.
class AutomaticDevice : public Gpu {
 protected:
  static RenderSettings automatic() {
    RenderSettings here = settings(3);
    here.device = DeviceKind::automatic;
    return here;
  }
  // Renders; the image must be that of the CPU. Returns the device.
  DeviceUse render_anywhere(RenderSettings here, const World& world) {
    Result<RenderOutcome> found = render(world, gpu_camera(), here, nullptr, nullptr);
    here.device = DeviceKind::cpu;
    const Result<RenderOutcome> expected = render(world, gpu_camera(), here, nullptr, nullptr);
    EXPECT_TRUE(found.ok() && expected.ok());
    if (!found.ok() || !expected.ok()) return {};
    expect_same_bits(found.value().film, expected.value().film, "a device chosen by itself");
    return found.value().statistics.device;
  }
};

TEST_F(AutomaticDevice, TakesTheGpu) {
  const DeviceUse use = render_anywhere(automatic(), *world_);
  EXPECT_EQ(use.name, "Fake GPU");
  EXPECT_GT(use.scene_bytes, 0U);
  EXPECT_EQ(use.why_cpu, "");
}

TEST_F(AutomaticDevice, TakesTheGpuForLightPaths) {
  RenderSettings here = small_render(kGpuImage, 3);
  here.device = DeviceKind::automatic;
  here.integrator.light_paths = 0.5f;
  EXPECT_EQ(render_anywhere(here, *caster_world(true)).name, "Fake GPU");
}

TEST_F(AutomaticDevice, TakesTheCpuWhereNoGpuCanBeOpened) {
  fail("devices=0");
  const DeviceUse use = render_anywhere(automatic(), *world_);
  EXPECT_EQ(use.name, "cpu");
  EXPECT_EQ(use.why_cpu, "no GPU: NVIDIA's driver knows none that can render");
}

TEST_F(AutomaticDevice, TakesTheCpuIfTheSceneHasNoRoom) {
  fail("memory=70000");
  const DeviceUse use = render_anywhere(automatic(), *world_);
  EXPECT_EQ(use.name, "cpu");
  EXPECT_EQ(use.scene_bytes, 0U);
  EXPECT_NE(use.why_cpu.find("no room for"), std::string::npos) << use.why_cpu;
  EXPECT_EQ(use.why_cpu.find("--device"), std::string::npos) << use.why_cpu;
}

TEST_F(AutomaticDevice, TakesTheCpuWithoutAKdTree) {
  const std::unique_ptr<const World> embree = mixed_world(accel::Kind::embree);
  EXPECT_NE(render_anywhere(automatic(), *embree).why_cpu.find("kd-tree"), std::string::npos);
}

} // namespace
} // namespace kindling::test
