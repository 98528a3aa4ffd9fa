// Atomic writing and reading of JSON files that several machines share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <nlohmann/json.hpp>

#include <filesystem>

namespace kindling {

// Writes a temporary file beside `path` and renames it, so that readers see the old text or the new
// one. Fails (input_output).
[[nodiscard]] Result<void> write_json_file(const std::filesystem::path& path, const nlohmann::ordered_json& json);
// Reads a JSON object. Fails (input_output) if the file cannot be read or contains anything else.
[[nodiscard]] Result<nlohmann::ordered_json> read_json_file(const std::filesystem::path& path);

} // namespace kindling
