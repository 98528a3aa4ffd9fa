// The shipped scenes: valid ones load without warnings, broken ones give the expected errors.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/load_gltf.h"
#include "renderer/scene/pose.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace kindling {
namespace {

namespace fs = std::filesystem;

class Warnings final : public ProgressListener {
 public:
  std::vector<std::string> lines;
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view message) override { lines.emplace_back(message); }
  void on_info(std::string_view) override {}
};

const fs::path kScenes = fs::path(KINDLING_SOURCE_DIR) / "scenes";

bool is_scene(const fs::path& path) { return path.extension() == ".gltf" || path.extension() == ".glb"; }

bool is_one_line(const Result<Scene>& scene) {
  return scene.ok() || scene.error().message.find('\n') == std::string::npos;
}

TEST(ShippedScenes, ValidScenesLoadAndPose) {
  size_t count = 0;
  for (const fs::path& folder : {kScenes, kScenes / "tiny"})
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (!is_scene(entry.path())) continue;
      ++count;
      Warnings warnings;
      const Result<Scene> scene = load_gltf(entry.path(), {.strict = true}, &warnings);
      ASSERT_TRUE(scene.ok()) << scene.error().message;
      EXPECT_TRUE(pose_scene(scene.value(), {.time_s = 0.5}).ok()) << entry.path();
      EXPECT_TRUE(warnings.lines.empty()) << entry.path() << testing::PrintToString(warnings.lines);
    }
  EXPECT_GE(count, 25U);
}

TEST(ShippedScenes, BrokenScenesReportExpectedErrors) {
  std::ifstream file(kScenes / "broken" / "expected.json");
  const nlohmann::json expected = nlohmann::json::parse(file);
  EXPECT_GE(expected.size(), 35U);
  for (const auto& [name, entry] : expected.items()) {
    const fs::path path = kScenes / "broken" / name;
    Warnings warnings;
    EXPECT_TRUE(is_one_line(load_gltf(path, {}, nullptr))) << name; // repairs some of them
    const Result<Scene> scene = load_gltf(path, {.strict = true}, &warnings);
    const std::string outcome = entry["outcome"];
    if (outcome == "any") continue; // must not crash
    ASSERT_EQ(scene.ok(), outcome == "warning") << name;
    if (outcome == "warning") {
      ASSERT_FALSE(warnings.lines.empty()) << name;
    }
    const std::string message = outcome == "warning" ? warnings.lines.front() : scene.error().message;
    const std::string pointer = entry["pointer"];
    EXPECT_NE(message.find(path.string() + ": " + pointer), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  // The list has every file of the folder.
  for (const fs::directory_entry& entry : fs::directory_iterator(kScenes / "broken"))
    EXPECT_TRUE(!is_scene(entry.path()) || expected.contains(entry.path().filename().string())) << entry.path();
}

} // namespace
} // namespace kindling
