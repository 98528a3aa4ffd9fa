// Converts texts to JSON and back.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/json_text.h"

#include <algorithm>

namespace kindling {

using Json = nlohmann::ordered_json;

Json text_to_json(const std::string& text) {
  Json json = text;
  try {
    static_cast<void>(json.dump());
  } catch (const Json::type_error&) {
    json = Json::array();
    for (const char c : text) json.push_back(static_cast<unsigned char>(c));
  }
  return json;
}

std::optional<std::string> text_from_json(const Json& json) {
  if (json.is_string()) return json.get<std::string>();
  if (!json.is_array()) return std::nullopt;
  std::string text;
  for (const Json& byte : json) {
    if (!byte.is_number_unsigned() || byte.get<uint64_t>() > 255) return std::nullopt;
    text += static_cast<char>(byte.get<unsigned>());
  }
  return text;
}

int json_depth(std::string_view text) {
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') in_string = !in_string;
    if (in_string) {
      i += c == '\\' ? 1 : 0;
      continue;
    }
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if (c == ']' || c == '}') --depth;
  }
  return deepest;
}

} // namespace kindling
