// Converts texts to JSON and back.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/json_text.h"

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

} // namespace kindling
