// Builds small glTF files for the importer's tests, and loads them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/load_gltf.h"

#include <nlohmann/json.hpp>

#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::test {

using nlohmann::json;

inline constexpr int kByte = 5120;
inline constexpr int kUnsignedByte = 5121;
inline constexpr int kShort = 5122;
inline constexpr int kUnsignedShort = 5123;
inline constexpr int kUnsignedInt = 5125;
inline constexpr int kFloat = 5126;

[[nodiscard]] std::string base64(std::string_view bytes);
[[nodiscard]] std::string data_uri(std::string_view bytes, std::string_view media_type = "application/octet-stream");

// Returns a .glb of the two chunks; no BIN chunk if `bin` is empty.
[[nodiscard]] std::string make_glb(std::string json_text, std::string bin);

// A temporary folder, removed at the end of the test.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::filesystem::path& name, std::string_view content) const;

 private:
  std::filesystem::path path_;
};

// A glTF file under construction: editable JSON and one buffer.
struct GltfBuilder {
  json root = {{"asset", {{"version", "2.0"}}}};
  std::string bin;

  // Appends bytes as a bufferView at a multiple of 4.
  int view(std::string_view bytes, int stride = 0);
  // Adds an accessor with a bufferView of its own, tightly packed.
  template <typename T>
  int accessor(const std::vector<T>& values, int component_type, const char* type, bool normalized = false) {
    const std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return accessor_of(view(bytes), values.size() / components(type), component_type, type, normalized);
  }
  int accessor_of(int buffer_view, size_t count, int component_type, const char* type, bool normalized = false);
  static size_t components(std::string_view type);

  int push(const char* list, json item); // returns its index
  int mesh(json primitive) { return push("meshes", {{"primitives", json::array({std::move(primitive)})}}); }
  // Adds a node, also to the scene.
  int root_node(json node);

  [[nodiscard]] std::string gltf() const; // the buffer as a data: URI
  [[nodiscard]] std::string glb() const;
};

// Returns one triangle in z = 0 with corners (0,0), (1,0), (0,1), on a node of a scene.
[[nodiscard]] GltfBuilder triangle();

// The result of load_gltf(): scene or error, and warnings, without the path of the file.
struct Loaded {
  std::optional<Scene> scene;
  std::string error;
  ErrorKind kind = ErrorKind::scene_invalid;
  std::vector<std::string> warnings;

  [[nodiscard]] bool warned(std::string_view part) const;
};

// Tests load strictly unless they say otherwise: valid files have no finding that is repaired, and
// faults show as errors.
inline const ImportOptions kStrict{.strict = true};
inline const ImportOptions kLenient{};

[[nodiscard]] Loaded load_file(const std::filesystem::path& path, const ImportOptions& options = kStrict);
[[nodiscard]] Loaded load_text(std::string_view content, const ImportOptions& options = kStrict,
                               const char* name = "test.gltf");
[[nodiscard]] Loaded load(const GltfBuilder& builder, const ImportOptions& options = kStrict);

// Images of one pixel in several formats.
extern const std::string_view kPngBase64;
extern const std::string_view kWebpBase64;
[[nodiscard]] std::string from_base64(std::string_view text);

} // namespace kindling::test
