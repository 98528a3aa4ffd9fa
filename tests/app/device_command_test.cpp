// `--device`: refusals and exit codes; parts and resumed renders of several devices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Words = std::vector<std::string>;

class DeviceCommand : public SceneFolder {
 protected:
  void SetUp() override {
    SceneFolder::SetUp();
    write_scene();
  }
  [[nodiscard]] ProgramResult render(Words flags) const {
    flags.insert(flags.begin(), {"render", "scene.gltf", "--size", "40x36", "--exr-float", "--quiet"});
    return run_program(flags, folder_);
  }
  void expect_rendered(const Words& flags) const {
    const ProgramResult result = render(flags);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  [[nodiscard]] std::vector<std::byte> pixels(const std::string& name) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    return image.ok() ? image.value().pixels : std::vector<std::byte>();
  }
};

TEST_F(DeviceCommand, FailuresAreOneLineAndLeaveNoImage) {
  ASSERT_EQ(setenv("KINDLING_CUDA_DRIVER", "/nowhere/libcuda.so.1", 1), 0);
  const ProgramResult no_driver = render({"--spp", "1", "--device", "gpu", "-o", "image.png"});
  unsetenv("KINDLING_CUDA_DRIVER");
  EXPECT_EQ(no_driver.exit_code, 1);
  EXPECT_EQ(no_driver.err_lines().size(), 1U) << no_driver.err;
  EXPECT_NE(no_driver.err.find("no GPU"), std::string::npos) << no_driver.err;
  EXPECT_NE(no_driver.err.find("use --device cpu"), std::string::npos) << no_driver.err;

  const ProgramResult embree = render({"--spp", "1", "--device", "host", "--accel", "embree", "-o", "image.png"});
  EXPECT_EQ(embree.exit_code, 2);
  EXPECT_NE(embree.err.find("use --accel kdtree"), std::string::npos) << embree.err;
  EXPECT_FALSE(exists("image.png"));
}

TEST_F(DeviceCommand, PartsOfSeveralDevicesMakeOneImage) {
  expect_rendered({"--spp", "8", "-o", "whole.exr"});
  expect_rendered({"--spp", "8", "--part", "1/2"});
  expect_rendered({"--spp", "8", "--part", "2/2", "--device", "host"});
  const ProgramResult merged = run_program(
      {"merge", "scene-part-1-of-2.kacc", "scene-part-2-of-2.kacc", "-o", "merged.exr", "--exr-float"}, folder_);
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr"));
}

TEST_F(DeviceCommand, CheckpointsMoveBetweenDevices) {
  expect_rendered({"--spp", "9", "--planned-spp", "16", "-o", "whole.exr"});
  const std::vector<std::pair<std::string, std::string>> ways{{"cpu", "host"}, {"host", "cpu"}};
  for (const auto& [first, second] : ways) {
    expect_rendered({"--spp", "4", "--planned-spp", "16", "--device", first, "--checkpoint", first + ".kacc", "-o",
                     first + ".exr"});
    const ProgramResult resumed =
        run_program({"resume", first + ".kacc", "--spp", "9", "--device", second, "--quiet"}, folder_);
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_EQ(pixels(first + ".exr"), pixels("whole.exr")) << first << " first";
  }
}

} // namespace
} // namespace kindling::test
