// Texts that may not be UTF-8, such as names of files, in JSON, whose strings must be.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <string_view>

namespace kindling {

// Returns a string, or an array of the text's bytes if it is not UTF-8.
[[nodiscard]] nlohmann::ordered_json text_to_json(const std::string& text);
// Returns the text of either; nothing for any other value.
[[nodiscard]] std::optional<std::string> text_from_json(const nlohmann::ordered_json& json);

// Returns the maximum nesting of lists and objects in a text that may be JSON.
[[nodiscard]] int json_depth(std::string_view text);

} // namespace kindling
