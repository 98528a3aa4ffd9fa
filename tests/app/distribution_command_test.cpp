// Several processes with a rectangle each make the image of one process.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <cstring>
#include <memory>

namespace kindling::test {
namespace {

class Distribution : public SceneFolder {
 protected:
  [[nodiscard]] std::vector<float> read_exr(const std::string& name) const {
    Result<Image> image = read_image_file(folder_ / name);
    EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
    if (!image.ok()) return {};
    std::vector<float> values(image.value().byte_count() / sizeof(float));
    std::memcpy(values.data(), image.value().pixels.data(), image.value().byte_count());
    return values;
  }
  [[nodiscard]] static std::vector<std::string> arguments(const std::string& integrator,
                                                          const std::vector<std::string>& more) {
    std::vector<std::string> all = {"render",       KINDLING_SCENES "/material_grid.glb",
                                    "--integrator", integrator,
                                    "--size",       "90x67",
                                    "--spp",        "2",
                                    "--exr-float",  "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

TEST_F(Distribution, CropsOfProcessesMakeTheWholeImage) {
  for (const std::string integrator : {"whitted", "path"}) {
    // The regions of four workers, as a coordinator would assign them.
    const std::vector<std::string> crops = {"0,0,48,32", "0,32,48,67", "48,0,90,32", "48,32,90,67"};
    std::vector<std::unique_ptr<Program>> processes;
    for (size_t i = 0; i < crops.size(); ++i)
      processes.push_back(std::make_unique<Program>(
          arguments(integrator, {"--crop", crops[i], "--threads", "1", "-o", std::to_string(i) + ".exr"}), folder_));
    for (const auto& process : processes) ASSERT_EQ(process->finish().exit_code, 0);
    ASSERT_EQ(run_program(arguments(integrator, {"-o", "whole.exr", "--threads", "2"}), folder_).exit_code, 0);

    const std::vector<float> whole = read_exr("whole.exr");
    ASSERT_EQ(whole.size(), 90U * 67U * 4U);
    std::vector<float> composed(whole.size(), 0.0f);
    for (size_t i = 0; i < crops.size(); ++i) {
      const std::vector<float> part = read_exr(std::to_string(i) + ".exr"); // black outside of its crop
      ASSERT_EQ(part.size(), whole.size());
      for (size_t v = 0; v < part.size(); ++v) composed[v] += part[v];
    }
    EXPECT_EQ(std::memcmp(composed.data(), whole.data(), whole.size() * sizeof(float)), 0) << integrator;
  }
}

TEST_F(Distribution, RegionsMakeTheSameImageAndReportIdleTime) {
  ASSERT_EQ(run_program(arguments("whitted", {"-o", "tiles.exr", "--threads", "2", "--stats", "tiles.json"}), folder_)
                .exit_code,
            0);
  ASSERT_EQ(run_program(arguments("whitted", {"-o", "regions.exr", "--threads", "3", "--schedule", "regions", "--stats",
                                              "regions.json"}),
                        folder_)
                .exit_code,
            0);
  EXPECT_EQ(read_exr("tiles.exr"), read_exr("regions.exr"));
  const auto tiles = nlohmann::json::parse(read_file("tiles.json"));
  const auto regions = nlohmann::json::parse(read_file("regions.json"));
  EXPECT_EQ(tiles["schedule"], "tiles");
  EXPECT_EQ(tiles["worker_idle_s"].size(), 2U);
  EXPECT_EQ(regions["schedule"], "regions");
  ASSERT_EQ(regions["worker_idle_s"].size(), 3U);
  double sum = 0.0;
  for (const double idle_s : regions["worker_idle_s"]) sum += idle_s;
  EXPECT_NEAR(sum, regions["idle_s"], 1e-9);
  EXPECT_EQ(regions["rays"], tiles["rays"]);
  EXPECT_EQ(regions["whitted"]["form"], "iterative");
  EXPECT_GT(regions["whitted"]["cache"]["hits"], 0);
}

// The three named tracers, and flags that override their settings.
TEST_F(Distribution, NamedTracersHaveTheirSettings) {
  const std::string scene = write_scene();
  const auto stats = [&](std::vector<std::string> more) {
    std::vector<std::string> all = {"render",  scene, "--size", "16x16",   "--spp", "1",
                                    "--quiet", "-o",  "a.png",  "--stats", "a.json"};
    all.insert(all.end(), more.begin(), more.end());
    EXPECT_EQ(run_program(all, folder_).exit_code, 0);
    return nlohmann::json::parse(read_file("a.json"));
  };
  const auto none = stats({"--tracer", "none"});
  EXPECT_EQ(none["integrator"], "whitted");
  EXPECT_EQ(none["accelerator"]["name"], "brute-force");
  EXPECT_EQ(none["whitted"]["form"], "recursive");
  EXPECT_EQ(none["whitted"]["cache"]["enabled"], false);
  EXPECT_EQ(none["whitted"]["max_reflections"], 8);
  const auto optimized = stats({"--max-reflections", "5", "--tracer", "optimized", "--trace-depth", "12"});
  EXPECT_EQ(optimized["accelerator"]["name"], "kdtree");
  EXPECT_EQ(optimized["whitted"]["form"], "iterative");
  EXPECT_EQ(optimized["whitted"]["cache"]["enabled"], true);
  EXPECT_EQ(optimized["whitted"]["max_reflections"], 5);
  EXPECT_EQ(stats({"--tracer", "optimized"})["whitted"]["max_reflections"], 3);
  const ProgramResult refused = run_program({"render", scene, "--trace-depth", "3"}, folder_);
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.err.find("--trace-depth"), std::string::npos);
}

} // namespace
} // namespace kindling::test
