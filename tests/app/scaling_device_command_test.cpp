// `kindling scaling --device` from end to end: equal images, a frame by both, failures.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <cstdlib>
#include <set>

namespace kindling::test {
namespace {

using Json = nlohmann::json;

class DeviceScalingCommand : public SceneFolder {
 protected:
  void TearDown() override {
    for (const char* name : {"KINDLING_CUDA_DRIVER", "FAKE_CUDA", "XDG_CACHE_HOME"}) unsetenv(name);
    SceneFolder::TearDown();
  }
  [[nodiscard]] ProgramResult scaling(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"scaling", KINDLING_SCENES "/cornell_box.glb", "--size", "48x40", "--threads", "1,2",
                                 "--spp", "3", "--repeat", "2", "--json", "a.json", "--quiet"});
    return run_program(flags, folder_);
  }
};

TEST_F(DeviceScalingCommand, ImagesOfAllSidesAreEqual) {
  for (const std::vector<std::string>& flags :
       {std::vector<std::string>{}, {"--noise-threshold", "0.3", "--outliers", "trim", "--crop", "3,5,45,39"}}) {
    std::vector<std::string> words{"--device", "host", "--accel", "embree,kdtree"};
    words.insert(words.end(), flags.begin(), flags.end());
    if (!flags.empty()) words.insert(words.end(), {"--spp", "24", "--min-spp", "16"});
    const ProgramResult result = scaling(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.out.find("2 images of host and 2 merged ones, bit-identical to those of kdtree"),
              std::string::npos)
        << result.out;
    const Json scene = Json::parse(read_file("a.json"))["scenes"][0];
    const Json& device = scene["device"];
    std::set<std::string> images;
    for (const char* way : {"alone", "shared"})
      for (const Json& image : device[way]["images"]) images.insert(image.get<std::string>());
    for (const Json& row : scene["accelerators"][1]["render"])
      for (const Json& image : row["images"]) images.insert(image.get<std::string>());
    EXPECT_EQ(images.size(), 1U);
    EXPECT_EQ(device["name"], "host");
    EXPECT_GT(device["scene_bytes"], 0);
    EXPECT_EQ(device["alone"]["processors"].size(), 2U);
    EXPECT_GT(device["alone"]["samples_per_s"], 0.0);
    EXPECT_GT(device["shared"]["processor_share"], 0.0);
    EXPECT_LT(device["shared"]["processor_share"], 1.0);
    EXPECT_TRUE(scene["mismatches"].empty());
  }
}

// The kernels of the driver for tests compute nothing, so the image is not the processor's.
TEST_F(DeviceScalingCommand, AnotherImageIsAnError) {
  setenv("KINDLING_CUDA_DRIVER", KINDLING_FAKE_CUDA, 1);
  setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
  const ProgramResult result = scaling({"--device", "gpu"});
  if (result.err.find("built without kernels") != std::string::npos)
    GTEST_SKIP() << "built without clang-19: there are no kernels for GPUs";
  EXPECT_EQ(result.exit_code, 1) << result.out;
  ASSERT_EQ(result.err_lines().size(), 1U) << result.err;
  EXPECT_NE(result.err.find("the image depends on the number of threads, the schedule or the device"),
            std::string::npos)
      << result.err;
  EXPECT_NE(result.out.find("  gpu, round 1: DIFFERENT IMAGE"), std::string::npos) << result.out;
}

TEST_F(DeviceScalingCommand, FailuresAreOneLine) {
  const auto expect_error = [&](std::vector<std::string> flags, int code, const std::string& words) {
    const ProgramResult result = scaling(std::move(flags));
    if (result.err.find("built without kernels") != std::string::npos) return;
    EXPECT_EQ(result.exit_code, code) << result.err;
    ASSERT_EQ(result.err_lines().size(), 1U) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  };
  expect_error({"--device", "host", "--accel", "embree"}, 2, "--device: a device renders with the kd-tree alone");
  expect_error({"--device", "auto"}, 2, "--device: unknown device 'auto'; use host or gpu");
  setenv("KINDLING_CUDA_DRIVER", "/nowhere/libcuda.so.1", 1);
  expect_error({"--device", "gpu"}, 1, "--device: no GPU: ");
  setenv("KINDLING_CUDA_DRIVER", KINDLING_FAKE_CUDA, 1);
  setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
  setenv("FAKE_CUDA", "lost=2", 1);
  expect_error({"--device", "gpu"}, 1, "--device: Fake GPU: ");
}

} // namespace
} // namespace kindling::test
