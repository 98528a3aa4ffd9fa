// The binary container of glTF 2.0 (section 4): its JSON and BIN chunks.
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

[[nodiscard]] bool is_glb(Bytes file); // by its magic bytes

// Spans point into `file`. Throws ImportFailure.
[[nodiscard]] GlbChunks split_glb(Bytes file, Warnings& warnings);

} // namespace kindling::gltf
