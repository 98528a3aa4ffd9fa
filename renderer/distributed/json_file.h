// JSON files that several machines read while one writes them: whole or not there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <nlohmann/json.hpp>

#include <filesystem>

namespace kindling {

// Written beside the name and renamed, so that a reader sees the old text or the new one. Fails (input_output).
[[nodiscard]] Result<void> write_json_file(const std::filesystem::path& path, const nlohmann::ordered_json& json);
// Fails (input_output) where the file cannot be read or is no JSON object.
[[nodiscard]] Result<nlohmann::ordered_json> read_json_file(const std::filesystem::path& path);

} // namespace kindling
