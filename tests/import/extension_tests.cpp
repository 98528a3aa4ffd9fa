// The table of extensions: README, messages, required and ignored extensions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/pose.h"
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace kindling::test {
namespace {

using Level = ExtensionSupport::Level;

TEST(Extensions, TableIsSortedAndUnique) {
  const std::vector<ExtensionSupport> list = supported_extensions();
  for (size_t i = 1; i < list.size(); ++i) EXPECT_LT(list[i - 1].name, list[i].name);
}

TEST(Extensions, SupportedExtensionsLoadWithoutWarning) {
  const std::vector<ExtensionSupport> list = supported_extensions();
  for (const char* name :
       {"KHR_texture_transform", "KHR_lights_punctual", "KHR_materials_unlit", "KHR_materials_emissive_strength",
        "KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_draco_mesh_compression", "EXT_texture_webp",
        "EXT_mesh_gpu_instancing", "KHR_node_visibility", "KHR_texture_basisu"}) {
    const auto found =
        std::find_if(list.begin(), list.end(), [&](const ExtensionSupport& e) { return e.name == name; });
    ASSERT_NE(found, list.end()) << name;
    EXPECT_EQ(found->level, Level::full) << name;
  }
}

TEST(Extensions, TableEqualsReadme) {
  std::ifstream stream(KINDLING_SOURCE_DIR "/renderer/import/README.md");
  ASSERT_TRUE(stream);
  std::stringstream text;
  text << stream.rdbuf();
  const std::string readme = text.str();
  const std::string table = extension_table_markdown();
  const size_t begin = readme.find(table.substr(0, table.find('\n') + 1));
  ASSERT_NE(begin, std::string::npos);
  EXPECT_EQ(readme.substr(begin, readme.find("\n\n", begin) + 1 - begin), table)
      << "put in what 'kindling info --extension-table' prints";
}

TEST(Extensions, MarkdownHasOneRowEach) {
  const std::string table = extension_table_markdown();
  for (const ExtensionSupport& extension : supported_extensions()) {
    const std::string row = "\n| " + std::string(extension.name) + " | " + std::string(name_of(extension.level)) +
                            " | " + std::string(extension.note) + (extension.note.empty() ? "|\n" : " |\n");
    EXPECT_NE(table.find(row), std::string::npos) << row;
  }
}

Loaded with_extensions(json used, json required) {
  GltfBuilder builder;
  builder.root["extensionsUsed"] = std::move(used);
  if (!required.empty()) builder.root["extensionsRequired"] = std::move(required);
  return load(builder);
}

TEST(Extensions, RefusesUnknownRequiredExtensionWithList) {
  const Loaded loaded =
      with_extensions({"KHR_lights_punctual", "ACME_hologram"}, {"KHR_lights_punctual", "ACME_hologram"});
  EXPECT_EQ(loaded.kind, ErrorKind::scene_invalid);
  const std::string start = "/extensionsRequired/1: 'ACME_hologram' is required but not supported; supported are ";
  ASSERT_EQ(loaded.error.substr(0, start.size()), start);
  for (const ExtensionSupport& extension : supported_extensions()) {
    const bool listed = loaded.error.find(std::string(extension.name)) != std::string::npos;
    EXPECT_EQ(listed, extension.level != Level::ignored) << extension.name;
  }
}

TEST(Extensions, IgnoredExtensionsWarnOnce) {
  GltfBuilder builder;
  builder.root["extensionsUsed"] = {"ACME_hologram", "KHR_lights_punctual"};
  for (int i = 0; i < 3; ++i) builder.push("materials", {{"extensions", {{"ACME_hologram", json::object()}}}});
  EXPECT_EQ(load(builder).warnings,
            (std::vector<std::string>{"/extensionsUsed/0: 'ACME_hologram' has no effect yet (unknown)"}));
}

// The center would move meshes, cameras and lights alike, so that an image cannot show it; none of
// them is moved, and no coordinate is rounded, wherever the center is.
TEST(Extensions, CenterOfCesiumRtcMovesNothing) {
  GltfBuilder builder = triangle();
  builder.root["extensionsUsed"] = {"KHR_lights_punctual", "CESIUM_RTC"};
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = json::parse(R"([{"type": "point"}])");
  builder.push("cameras", json::parse(R"({"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}})"));
  builder.root_node(json::parse(R"({"camera": 0, "translation": [0.1, 0.2, 3.3]})"));
  builder.root_node(json::parse(
      R"({"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [1.7, 0.3, 0.9], "rotation": [0, 0.6, 0, 0.8]})"));
  const Loaded plain = load(builder);
  ASSERT_TRUE(plain.scene) << plain.error;
  const PosedScene expected = pose_scene(*plain.scene, {}).value();
  for (const char* center : {"[6378137.123, -4500000.7, 12345.6]", "[1e15, 1e15, -1e15]", "[1e300, 0, 0]"}) {
    builder.root["extensions"]["CESIUM_RTC"]["center"] = json::parse(center);
    const Loaded moved = load(builder);
    ASSERT_TRUE(moved.scene) << moved.error;
    EXPECT_TRUE(moved.warnings.empty());
    EXPECT_EQ(moved.scene->meshes[0].primitives[0].positions, plain.scene->meshes[0].primitives[0].positions);
    const PosedScene posed = pose_scene(*moved.scene, {}).value();
    ASSERT_EQ(posed.meshes.size(), 1U);
    ASSERT_EQ(posed.cameras.size(), 1U);
    ASSERT_EQ(posed.lights.size(), 1U);
    EXPECT_EQ(posed.meshes[0].mesh_to_world, expected.meshes[0].mesh_to_world);
    EXPECT_EQ(posed.cameras[0].camera_to_world, expected.cameras[0].camera_to_world);
    EXPECT_EQ(posed.lights[0].light_to_world, expected.lights[0].light_to_world);
  }
}

TEST(Extensions, RefusesOverlongLists) {
  json names = json::array();
  for (int i = 0; i < 1001; ++i) names.push_back("ACME_" + std::to_string(i));
  EXPECT_EQ(with_extensions(names, {}).error, "/extensionsUsed: 1001 names, at most 1000 are accepted");
}

TEST(Extensions, VariantsAreListed) {
  GltfBuilder builder;
  builder.root["extensions"]["KHR_materials_variants"]["variants"] =
      json::parse(R"([{"name": "red"}, {"name": "blue"}])");
  EXPECT_EQ(load(builder).scene->variants, (std::vector<std::string>{"red", "blue"}));
}

} // namespace
} // namespace kindling::test
