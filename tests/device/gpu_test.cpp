// Renders on a GPU whose driver is a stand-in: its images, its failures, and what it leaves behind.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/cuda_device.h"
#include "renderer/device/kernels/all_kernels.h"
#include "renderer/session/render_session.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

namespace kindling::test {
namespace {

const V2i kGpuImage(40, 28);

Camera gpu_camera() { return {SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kGpuImage}; }

void run_kernel(const char* name, const void* argument, unsigned count) {
#define KINDLING_RUN_NAMED(kernel, type)                                                                               \
  if (std::strcmp(name, "kindling_" #kernel) == 0)                                                                     \
    for (unsigned i = 0; i < count; ++i) kernels::kernel(*static_cast<const type*>(argument), i);
  KINDLING_KERNELS(KINDLING_RUN_NAMED)
#undef KINDLING_RUN_NAMED
}

class Gpu : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_gpu_kernels()) GTEST_SKIP() << "built without clang-19: there are no kernels for GPUs";
    library_ = dlopen(KINDLING_FAKE_CUDA, RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library_, nullptr) << dlerror();
    *static_cast<void (**)(const char*, const void*, unsigned)>(dlsym(library_, "fake_cuda_run")) = run_kernel;
    setenv("KINDLING_CUDA_DRIVER", KINDLING_FAKE_CUDA, 1);
    fail("");
  }
  void TearDown() override {
    if (library_ == nullptr) return;
    EXPECT_EQ(reinterpret_cast<size_t (*)()>(dlsym(library_, "fake_cuda_allocations"))(), 0U);
    unsetenv("KINDLING_CUDA_DRIVER");
    unsetenv("FAKE_CUDA");
    dlclose(library_);
  }

  static void fail(const std::string& how) { setenv("FAKE_CUDA", how.c_str(), 1); }
  static RenderSettings settings(uint32_t samples) {
    RenderSettings settings = small_render(kGpuImage, samples);
    for (const AovInfo& info : kAovs)
      if (!is_light_pass(info.aov) && !is_of_nearest(info.aov)) settings.aovs.insert(info.aov);
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
  void expect_message(const std::string& part) { EXPECT_NE(message().find(part), std::string::npos) << message(); }

  std::unique_ptr<const World> world_ = mixed_world(accel::Kind::kdtree);

 private:
  void* library_ = nullptr;
};

TEST_F(Gpu, RendersTheSameImageAsTheCpu) {
  RenderSettings here = settings(6);
  Result<RenderOutcome> gpu = render(*world_, gpu_camera(), here, nullptr, nullptr);
  ASSERT_TRUE(gpu.ok()) << gpu.error().message;
  here.device = DeviceKind::cpu;
  const Result<RenderOutcome> cpu = render(*world_, gpu_camera(), here, nullptr, nullptr);
  expect_same_bits(gpu.value().film, cpu.value().film, "the GPU's driver");
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

TEST_F(Gpu, LackOfMemoryIsReportedWithFigures) {
  fail("memory=8192");
  expect_message("no room for 0 MiB (0 of its 0 MiB are free): out of memory (CUDA_ERROR_OUT_OF_MEMORY)");
  fail("memory=100000000");
  expect_message("of its 95 MiB are free)");
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

} // namespace
} // namespace kindling::test
