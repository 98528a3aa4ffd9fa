// Reads a glTF file and its buffers into a checked Document.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/import/document/document.h"
#include "renderer/import/files/failure.h"
#include "renderer/import/files/import_limits.h"

#include <filesystem>
#include <vector>

namespace kindling::gltf {

// Reads the file and its buffers, decompresses bufferViews, and checks JSON, extensions, buffers,
// bufferViews and bounds of accessors. Throws ImportFailure.
[[nodiscard]] Document open_document(const std::filesystem::path& path, const ImportLimits& limits, Warnings& warnings);

// Returns the files that the scene names (find_scene_files()), and reads none of them. Throws
// ImportFailure.
[[nodiscard]] std::vector<std::filesystem::path> list_files(const std::filesystem::path& path,
                                                            const ImportLimits& limits);

} // namespace kindling::gltf
