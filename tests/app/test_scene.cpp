// Small glTF scenes for the tests of the command line.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/test_scene.h"

#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <vector>

namespace kindling::test {

void SceneFolder::SetUp() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  folder_ = std::filesystem::temp_directory_path() / ("kindling_app_" + std::to_string(getpid()) + "_" + info->name());
  std::filesystem::create_directories(folder_);
}

void SceneFolder::TearDown() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void SceneFolder::write_file(const std::string& name, const std::string& contents) const {
  std::ofstream(folder_ / name, std::ios::binary) << contents;
}

std::string SceneFolder::read_file(const std::string& name) const {
  std::ifstream file(folder_ / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string SceneFolder::write_scene(const std::string& name, const TestSceneOptions& options) const {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  const int side = options.grid + 1;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      positions.push_back(static_cast<float>(x) / static_cast<float>(options.grid) - 0.5f);
      positions.push_back(static_cast<float>(y) / static_cast<float>(options.grid) - 0.5f);
      positions.push_back(0.0f);
    }
  for (int y = 0; y < options.grid; ++y)
    for (int x = 0; x < options.grid; ++x) {
      const auto corner = static_cast<uint32_t>(y * side + x);
      const auto above = corner + static_cast<uint32_t>(side);
      for (const uint32_t index : {corner, corner + 1, above + 1, corner, above + 1, above}) indices.push_back(index);
    }
  const size_t position_bytes = positions.size() * sizeof(float);
  const size_t index_bytes = indices.size() * sizeof(uint32_t);
  std::string buffer(position_bytes + index_bytes, '\0');
  std::copy_n(reinterpret_cast<const char*>(positions.data()), position_bytes, buffer.data());
  std::copy_n(reinterpret_cast<const char*>(indices.data()), index_bytes, buffer.data() + position_bytes);
  write_file(name + ".bin", buffer);

  const auto number = [](size_t value) { return std::to_string(value); };
  std::string nodes = R"({"name": "square", "mesh": 0})";
  std::string roots = "0";
  std::string members;
  if (options.camera) {
    roots += ", 1";
    nodes += R"(, {"name": "Front", "camera": 0, "translation": [0, 0, 2]})";
    members +=
        R"(, "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1, "znear": 0.1}}])";
  }
  if (options.light) {
    roots += options.camera ? ", 2" : ", 1";
    nodes += R"(, {"translation": [1, 1, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}})";
    members += R"(, "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual":
      {"lights": [{"type": "point", "intensity": 20}]}})";
  }
  write_file(
      name + ".gltf",
      R"({"asset": {"version": "2.0", "generator": "test"}, "scene": 0, "scenes": [{"name": "Stage", "nodes": [)" +
          roots + R"(]}], "nodes": [)" + nodes + R"(], "materials": [{"name": "gray",
      "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}}],
    "meshes": [{"name": "grid", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
    "buffers": [{"uri": ")" +
          std::filesystem::path(name).filename().string() + R"(.bin", "byteLength": )" + number(buffer.size()) + R"(}],
    "bufferViews": [{"buffer": 0, "byteLength": )" +
          number(position_bytes) + R"(},
      {"buffer": 0, "byteOffset": )" +
          number(position_bytes) + R"(, "byteLength": )" + number(index_bytes) + R"(}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "min": [-0.5, -0.5, 0], "max": [0.5, 0.5, 0],
      "count": )" +
          number(positions.size() / 3) + R"(}, {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": )" +
          number(indices.size() + static_cast<size_t>(options.accessor_count_delta)) + "}]" + members + options.extra +
          "}");
  return name + ".gltf";
}

} // namespace kindling::test
