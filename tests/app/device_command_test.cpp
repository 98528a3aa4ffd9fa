// `--device`: refusals and exit codes; parts and resumed renders of several devices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdint>
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

// A scene with textures of a few megabytes.
class DeviceMemoryCommand : public DeviceCommand {
 protected:
  [[nodiscard]] ProgramResult interior(Words flags) const {
    const Words fixed{
        "render", KINDLING_SCENES "/interior.glb", "--size", "64x36", "--spp", "2", "--guiding", "off", "--exr-float"};
    flags.insert(flags.begin(), fixed.begin(), fixed.end());
    return run_program(flags, folder_);
  }
  [[nodiscard]] nlohmann::json device_of(const std::string& stats) const {
    return nlohmann::json::parse(read_file(stats))["device"];
  }
};

TEST_F(DeviceMemoryCommand, PagedTexturesGiveTheSameImageWithinTheLimit) {
  ASSERT_EQ(interior({"-o", "cpu.exr"}).exit_code, 0);
  ASSERT_EQ(interior({"--device", "host", "-o", "whole.exr", "--stats", "whole.json"}).exit_code, 0);
  const nlohmann::json whole = device_of("whole.json");
  EXPECT_TRUE(whole["tiles"].is_null());
  EXPECT_GT(whole["peak_bytes"], whole["scene_bytes"]);
  const auto scene_bytes = whole["scene_bytes"].get<uint64_t>();
  const std::string limit = std::to_string(scene_bytes + (2 << 20));
  for (const std::string texture_memory : {"1G", "64K"}) { // texels in memory, and on disk
    const ProgramResult paged = interior({"--device", "host", "--device-memory", limit, "--texture-memory",
                                          texture_memory, "--verbose", "-o", "paged.exr", "--stats", "paged.json"});
    ASSERT_EQ(paged.exit_code, 0) << paged.err;
    const nlohmann::json device = device_of("paged.json");
    EXPECT_LE(device["peak_bytes"], scene_bytes + (2 << 20));
    EXPECT_GT(device["tiles"]["loaded"], 0);
    EXPECT_LT(device["tiles"]["slots"], device["tiles"]["tiles"]);
    EXPECT_NE(paged.err.find(" stages run again"), std::string::npos) << paged.err;
    EXPECT_EQ(pixels("paged.exr"), pixels("cpu.exr")) << texture_memory;
  }
}

TEST_F(DeviceMemoryCommand, TooLittleIsOneLineWithFigures) {
  const ProgramResult refused = interior({"--device", "host", "--device-memory", "1M", "--quiet", "-o", "image.exr"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_EQ(refused.err_lines().size(), 1U) << refused.err;
  EXPECT_NE(refused.err.find("needs at least"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("larger --device-memory"), std::string::npos) << refused.err;
  EXPECT_FALSE(exists("image.exr"));
  EXPECT_EQ(interior({"--device-memory", "much", "-o", "image.exr"}).exit_code, 2);
  for (const Words& cpu : {Words{}, Words{"--device", "cpu"}}) {
    Words flags{"--device-memory", "6G", "-o", "image.exr"};
    flags.insert(flags.end(), cpu.begin(), cpu.end());
    const ProgramResult unused = interior(flags);
    EXPECT_EQ(unused.exit_code, 2);
    EXPECT_NE(unused.err.find("--device-memory: has no meaning with --device cpu"), std::string::npos) << unused.err;
  }
}

// The minimum of `info` is enough, and not far above the truth.
TEST_F(DeviceMemoryCommand, TheMinimumOfInfoIsEnough) {
  const ProgramResult info =
      run_program({"info", KINDLING_SCENES "/interior.glb", "--size", "64x36", "--json"}, folder_);
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const nlohmann::json device = nlohmann::json::parse(info.out)["memory"]["device"];
  const auto min_bytes = device["min_bytes"].get<uint64_t>();
  EXPECT_LT(min_bytes, device["scene_bytes"].get<uint64_t>() + device["wave_bytes"].get<uint64_t>());
  const auto within = [&](uint64_t bytes) {
    return interior({"--device", "host", "--device-memory", std::to_string(bytes), "-o", "image.exr"}).exit_code;
  };
  EXPECT_EQ(within(min_bytes), 0);
  constexpr uint64_t kAllowed = 36 << 20; // 24 MiB for the guide, 12 for any tree
  EXPECT_EQ(within((min_bytes - kAllowed) / 2), 1);
}

} // namespace
} // namespace kindling::test
