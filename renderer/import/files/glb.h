// The binary container of glTF 2.0 (section 4): JSON and BIN chunks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/import/files/file_bytes.h"

#include <filesystem>
#include <optional>

namespace kindling::gltf {

struct GlbChunks {
  Bytes json;
  std::optional<Bytes> bin;
};

[[nodiscard]] bool is_glb(Bytes file); // true if the file starts with the magic bytes "glTF"

// Returns the chunks as spans of `file`; `path` appears in errors. A BIN chunk that the file cuts
// short has the bytes that exist, unless `warnings` is strict. Throws ImportFailure.
[[nodiscard]] GlbChunks split_glb(Bytes file, const std::filesystem::path& path, Warnings& warnings);

} // namespace kindling::gltf
