// Base64, .glb containers, temporary folders, and the builder.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/gltf_builder.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <atomic>
#include <fstream>

namespace kindling::test {
namespace {

constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

class Recorder : public ProgressListener {
 public:
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view message) override { warnings.emplace_back(message); }
  void on_info(std::string_view) override {}
  std::vector<std::string> warnings;
};

std::string without_path(std::string text, const std::filesystem::path& path) {
  const std::string prefix = path.string() + ": ";
  EXPECT_EQ(text.substr(0, prefix.size()), prefix) << "every message starts with the file";
  EXPECT_EQ(text.find('\n'), std::string::npos) << "every message is one line: " << text;
  return text.substr(std::min(prefix.size(), text.size()));
}

} // namespace

const std::string_view kPngBase64 =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";
const std::string_view kWebpBase64 = "UklGRhoAAABXRUJQVlA4TA0AAAAvAAAAEAcQERGIiP4HAA==";

std::string base64(std::string_view bytes) {
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](size_t k) {
      return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : static_cast<unsigned char>(0);
    };
    const uint32_t bits = (static_cast<uint32_t>(at(i)) << 16) | (static_cast<uint32_t>(at(i + 1)) << 8) | at(i + 2);
    out += kAlphabet[bits >> 18];
    out += kAlphabet[(bits >> 12) & 63U];
    out += i + 1 < bytes.size() ? kAlphabet[(bits >> 6) & 63U] : '=';
    out += i + 2 < bytes.size() ? kAlphabet[bits & 63U] : '=';
  }
  return out;
}

std::string from_base64(std::string_view text) {
  std::string out;
  uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = (bits << 6) | static_cast<uint32_t>(kAlphabet.find(c));
    count += 6;
    if (count >= 8) {
      count -= 8;
      out += static_cast<char>((bits >> count) & 0xffU);
    }
  }
  return out;
}

std::string data_uri(std::string_view bytes, std::string_view media_type) {
  return "data:" + std::string(media_type) + ";base64," + base64(bytes);
}

std::string make_glb(std::string json_text, std::string bin) {
  const auto u32 = [](size_t value) {
    std::string bytes(4, '\0');
    const auto number = static_cast<uint32_t>(value);
    std::memcpy(bytes.data(), &number, 4);
    return bytes;
  };
  json_text.resize((json_text.size() + 3) / 4 * 4, ' ');
  bin.resize((bin.size() + 3) / 4 * 4, '\0');
  std::string chunks = u32(json_text.size()) + "JSON" + json_text;
  if (!bin.empty()) chunks += u32(bin.size()) + std::string("BIN\0", 4) + bin;
  return "glTF" + u32(2) + u32(12 + chunks.size()) + chunks;
}

TempFolder::TempFolder() {
  static std::atomic<int> number{0};
  path_ = std::filesystem::temp_directory_path() /
          ("kindling_import_" + std::to_string(getpid()) + "_" + std::to_string(number.fetch_add(1)));
  std::filesystem::create_directories(path_);
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TempFolder::write(const std::filesystem::path& name, std::string_view content) const {
  const std::filesystem::path file = path_ / name;
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
  return file;
}

int GltfBuilder::push(const char* list, json item) {
  root[list].push_back(std::move(item));
  return static_cast<int>(root[list].size()) - 1;
}

int GltfBuilder::view(std::string_view bytes, int stride) {
  bin.resize((bin.size() + 3) / 4 * 4, '\0');
  json view = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes.size()}};
  if (stride != 0) view["byteStride"] = stride;
  bin += bytes;
  return push("bufferViews", std::move(view));
}

int GltfBuilder::accessor_of(int buffer_view, size_t count, int component_type, const char* type, bool normalized) {
  json accessor = {{"bufferView", buffer_view}, {"componentType", component_type}, {"count", count}, {"type", type}};
  if (normalized) accessor["normalized"] = true;
  return push("accessors", std::move(accessor));
}

size_t GltfBuilder::components(std::string_view type) {
  return type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 16;
}

int GltfBuilder::root_node(json node) {
  const int index = push("nodes", std::move(node));
  if (!root.contains("scenes")) root["scenes"] = json::array({json{{"nodes", json::array()}}});
  root["scenes"][0]["nodes"].push_back(index);
  return index;
}

std::string GltfBuilder::gltf() const {
  json with_buffer = root;
  if (!bin.empty() && !root.contains("buffers")) {
    with_buffer["buffers"] = json::array({json{{"byteLength", bin.size()}, {"uri", data_uri(bin)}}});
  }
  return with_buffer.dump();
}

std::string GltfBuilder::glb() const {
  json with_buffer = root;
  if (!bin.empty() && !root.contains("buffers")) {
    with_buffer["buffers"] = json::array({json{{"byteLength", bin.size()}}});
  }
  return make_glb(with_buffer.dump(), bin);
}

GltfBuilder triangle() {
  GltfBuilder builder;
  const int position = builder.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, kFloat, "VEC3");
  const int mesh = builder.mesh({{"attributes", {{"POSITION", position}}}});
  builder.root_node({{"mesh", mesh}});
  return builder;
}

bool Loaded::warned(std::string_view part) const {
  return std::any_of(warnings.begin(), warnings.end(),
                     [&](const std::string& warning) { return warning.find(part) != std::string::npos; });
}

Loaded load_file(const std::filesystem::path& path, const ImportOptions& options) {
  Recorder recorder;
  Result<Scene> scene = load_gltf(path, options, &recorder);
  Loaded loaded;
  for (std::string& warning : recorder.warnings) loaded.warnings.push_back(without_path(std::move(warning), path));
  if (scene) {
    loaded.scene = std::move(scene).value();
  } else {
    loaded.error = without_path(scene.error().message, path);
    loaded.kind = scene.error().kind;
  }
  return loaded;
}

Loaded load_text(std::string_view content, const ImportOptions& options, const char* name) {
  const TempFolder folder;
  return load_file(folder.write(name, content), options);
}

Loaded load(const GltfBuilder& builder, const ImportOptions& options) { return load_text(builder.gltf(), options); }

} // namespace kindling::test
