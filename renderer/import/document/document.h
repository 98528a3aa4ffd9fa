// An opened glTF file: checked JSON, tinygltf's structs of the core, and the bytes of its buffers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/import/files/file_bytes.h"
#include "renderer/import/files/import_limits.h"
#include "renderer/import/json/tinygltf_core.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <map>
#include <memory>
#include <vector>

namespace kindling::gltf {

// The decompressed bytes of a bufferView; none if its buffer has no data, as extensions permit.
struct ViewBytes {
  Bytes bytes;
  size_t length = 0; // as declared, even without bytes; less where the buffer ends before
  size_t stride = 0; // 0: elements are tightly packed
  [[nodiscard]] bool has_data() const { return !bytes.empty(); }
};

struct Document {
  std::filesystem::path path;
  std::vector<std::filesystem::path> files; // of find_scene_files()
  ImportLimits limits;
  std::unique_ptr<nlohmann::json> json; // the source of extensions; valid against kGltfSchema
  tinygltf::Model core;                 // no buffers, images, extensions or extras; absent bufferViews are -1
  std::vector<Bytes> buffers;           // empty: no data
  std::vector<ViewBytes> views;
  uint64_t bytes_read = 0;
  uint64_t elements_used = 0; // charged by ElementBudget
  uint64_t content_hash = 0;

  // Accessors that must not be read, with their faults; view_accessor() throws them.
  std::map<int, ImportFailure> faulty_accessors;

  std::vector<OwnedBytes> storage; // memory of the spans above

  Document();
  Document(Document&&) noexcept;
  Document& operator=(Document&&) noexcept;
  ~Document();
};

} // namespace kindling::gltf
