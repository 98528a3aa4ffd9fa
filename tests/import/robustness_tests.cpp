// Truncated and changed files give a scene or a one-line error (most useful with sanitizers).
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include "renderer/scene/pose.h"

#include <gtest/gtest.h>

#include <random>

namespace kindling::test {
namespace {

constexpr uint32_t kSeed = 20240917;

// Returns a file with a little of everything that the importer reads.
GltfBuilder everything() {
  GltfBuilder builder = triangle();
  json& primitive = builder.root["meshes"][0]["primitives"][0];
  json& attributes = primitive["attributes"];
  attributes["NORMAL"] = builder.accessor<int8_t>({0, 0, 127, 0, 0, 127, 0, 0, 127}, kByte, "VEC3", true);
  attributes["TEXCOORD_0"] = builder.accessor<uint16_t>({0, 0, 65535, 0, 0, 65535}, kUnsignedShort, "VEC2", true);
  attributes["COLOR_0"] = builder.accessor<uint8_t>({255, 0, 0, 0, 255, 0, 0, 0, 255}, kUnsignedByte, "VEC3", true);
  attributes["JOINTS_0"] = builder.accessor<uint8_t>({0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, kUnsignedByte, "VEC4");
  attributes["WEIGHTS_0"] = builder.accessor<float>({.5f, .5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, kFloat, "VEC4");
  primitive["indices"] = builder.accessor<uint16_t>({0, 1, 2, 2}, kUnsignedShort, "SCALAR");
  primitive["mode"] = 5;
  primitive["targets"] = json::array({json{{"POSITION", attributes["POSITION"]}}});
  primitive["material"] = builder.push("materials", {{"normalTexture", {{"index", 0}}},
                                                     {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  builder.push("textures", {{"source", 0}});
  builder.push("images", {{"bufferView", builder.view(from_base64(kPngBase64))}, {"mimeType", "image/png"}});
  json& node = builder.root["nodes"][0];
  node["skin"] = 0;
  node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      builder.accessor<float>({1, 2, 3}, kFloat, "VEC3");
  const int a = builder.push("nodes", {{"camera", 0}});
  const int b = builder.push("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  builder.root_node({{"children", {a, b}}});
  std::vector<float> matrices(32, 0.0f);
  for (size_t i = 0; i < 8; ++i) matrices[i / 4 * 16 + i % 4 * 5] = 1.0f;
  builder.push("skins", {{"joints", {a, b}}, {"inverseBindMatrices", builder.accessor(matrices, kFloat, "MAT4")}});
  builder.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = json::parse(R"([{"type": "spot", "spot": {}}])");
  const int times = builder.accessor<float>({0, 1}, kFloat, "SCALAR");
  const int weights = builder.accessor<float>({0, 1}, kFloat, "SCALAR");
  const int rotation = builder.accessor<float>(std::vector<float>(24, 0.5f), kFloat, "VEC4");
  builder.push(
      "animations",
      {{"channels",
        json::parse(
            R"([{"sampler": 0, "target": {"node": 0, "path": "weights"}}, {"sampler": 1, "target": {"node": 1, "path": "rotation"}}])")},
       {"samplers", json::array({json{{"input", times}, {"output", weights}},
                                 json{{"input", times}, {"output", rotation}, {"interpolation", "CUBICSPLINE"}}})}});
  return builder;
}

// Loads and poses a file, with repairs and without; the sanitizers do the rest. Returns the outcome
// of the strict load, which accepts no more files than the other.
bool survives(const TempFolder& folder, const std::string& content, const char* name) {
  const auto poses = [&](const ImportOptions& options) {
    const Loaded loaded = load_file(folder.write(name, content), options);
    EXPECT_EQ(loaded.error.empty(), loaded.scene.has_value());
    if (!loaded.scene) return false;
    return pose_scene(*loaded.scene, {.scene = loaded.scene->scenes.empty() ? kNone : 0, .time_s = 0.5}).ok();
  };
  const bool lenient = poses(kLenient);
  const bool strict = poses(kStrict);
  EXPECT_TRUE(lenient || !strict);
  return strict;
}

TEST(Robustness, CompleteFileLoads) {
  const TempFolder folder;
  EXPECT_TRUE(survives(folder, everything().glb(), "test.glb"));
  const Loaded loaded = load(everything());
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
}

TEST(Robustness, SurvivesTruncation) {
  const TempFolder folder;
  const std::string whole = everything().glb();
  for (size_t length = 0; length < whole.size(); length += 7)
    EXPECT_FALSE(survives(folder, whole.substr(0, length), "test.glb")) << length;
  const std::string text = everything().gltf();
  for (size_t length = 0; length + 1 < text.size(); length += 37)
    EXPECT_FALSE(survives(folder, text.substr(0, length), "test.gltf")) << length;
}

TEST(Robustness, SurvivesChangedBytes) {
  const TempFolder folder;
  const std::string whole = everything().glb();
  std::mt19937 random(kSeed);
  int fine = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string bytes = whole;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int c = 0; c < changes; ++c) bytes[random() % bytes.size()] = static_cast<char>(random());
    fine += survives(folder, bytes, "test.glb") ? 1 : 0;
  }
  EXPECT_GT(fine, 0) << "some changes do not matter";
}

TEST(Robustness, SurvivesChangedNumbers) {
  const TempFolder folder;
  const GltfBuilder good = everything();
  const std::string text = good.gltf();
  const std::vector<std::string> others = {"0",    "1",     "-1",   "2147483647", "4294967296", "9007199254740992",
                                           "1e38", "1e999", "0.5",  "null",       "[]",         "{}",
                                           "\"\"", "true",  "5126", "16"};
  std::mt19937 random(kSeed);
  std::vector<std::pair<size_t, size_t>> numbers;
  for (size_t i = 0; i < text.find("\"buffers\""); ++i) {
    if (std::isdigit(static_cast<unsigned char>(text[i])) == 0 ||
        (i > 0 && (std::isalnum(static_cast<unsigned char>(text[i - 1])) != 0 || text[i - 1] == '_')))
      continue;
    size_t end = i;
    while (end < text.size() && (std::isdigit(static_cast<unsigned char>(text[end])) != 0 || text[end] == '.')) ++end;
    numbers.emplace_back(i, end);
    i = end;
  }
  ASSERT_GT(numbers.size(), 50U);
  for (const auto& [start, end] : numbers) {
    for (int i = 0; i < 6; ++i)
      survives(folder, text.substr(0, start) + others[random() % others.size()] + text.substr(end), "test.gltf");
  }
}

} // namespace
} // namespace kindling::test
