// A glTF file taken apart: its checked JSON, tinygltf's structs of the core, and the bytes of its buffers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/import/files/file_bytes.h"
#include "renderer/import/files/import_limits.h"
#include "renderer/import/json/tinygltf_core.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <memory>
#include <vector>

namespace kindling::gltf {

// What a bufferView holds, decompressed. No bytes where its buffer has no data (a file may leave that to an extension).
struct ViewBytes {
  Bytes bytes;
  size_t length = 0; // declared, also where there are no bytes
  size_t stride = 0; // 0: elements are tightly packed
  [[nodiscard]] bool has_data() const { return !bytes.empty(); }
};

struct Document {
  std::filesystem::path path;
  ImportLimits limits;
  std::unique_ptr<nlohmann::json> json; // extensions are read from here; fits kGltfSchema
  tinygltf::Model core;                 // no buffers, images, extensions or extras; absent bufferViews are -1
  std::vector<Bytes> buffers;           // empty: no data
  std::vector<ViewBytes> views;
  uint64_t bytes_read = 0;
  uint64_t elements_used = 0; // of the limits: ElementBudget
  uint64_t content_hash = 0;

  std::vector<OwnedBytes> storage; // what the spans above point into

  Document();
  Document(Document&&) noexcept;
  Document& operator=(Document&&) noexcept;
  ~Document();
};

} // namespace kindling::gltf
