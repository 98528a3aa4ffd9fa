// The binary container of glTF 2.0 (section 4): JSON and BIN chunks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/files/failure.h"
#include "renderer/import/files/file_bytes.h"

#include <optional>

namespace kindling::gltf {

struct GlbChunks {
  Bytes json;
  std::optional<Bytes> bin;
};

[[nodiscard]] bool is_glb(Bytes file); // true if the file starts with the magic bytes "glTF"

// Returns the chunks as spans of `file`. Throws ImportFailure.
[[nodiscard]] GlbChunks split_glb(Bytes file, Warnings& warnings);

} // namespace kindling::gltf
