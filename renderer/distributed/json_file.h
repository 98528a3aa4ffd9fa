// Atomic writing and reading of JSON files that several machines share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace kindling {

// Writes a temporary file beside `path` and renames it, so that readers see the old text or the new
// one. Fails (input_output).
[[nodiscard]] Result<void> write_json_file(const std::filesystem::path& path, const nlohmann::ordered_json& json);
// Reads a JSON object. Fails (input_output) if the file cannot be read or contains anything else.
[[nodiscard]] Result<nlohmann::ordered_json> read_json_file(const std::filesystem::path& path);

// Thrown by the functions below; readers of files convert it to an error.
struct NotAWholeNumber {
  std::string message; // "'parts' is 1e+300; use a whole number from -2147483648 to 2147483647"
};
// Return member `key` of an object as an int, or as a list of them. Unlike nlohmann's get<int>(),
// they refuse fractions and numbers that an int cannot hold. Throw NotAWholeNumber, and
// nlohmann::json::exception for a missing member.
[[nodiscard]] int whole_number(const nlohmann::ordered_json& object, const char* key);
[[nodiscard]] std::vector<int> whole_numbers(const nlohmann::ordered_json& object, const char* key);

} // namespace kindling
