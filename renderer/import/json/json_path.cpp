// JSON pointers, and descriptions of values.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/json_path.h"

#include "renderer/import/files/failure.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace kindling::gltf {

std::string JsonPath::pointer() const {
  std::string pointer;
  for (const auto& step : steps_) {
    if (const size_t* index = std::get_if<size_t>(&step)) {
      pointer += fmt::format("/{}", *index);
      continue;
    }
    pointer += '/';
    for (const char c : std::get<std::string_view>(step)) {
      if (c == '~') {
        pointer += "~0";
      } else if (c == '/') {
        pointer += "~1";
      } else if (static_cast<unsigned char>(c) < 0x20) {
        pointer += '?';
      } else {
        pointer += c;
      }
    }
  }
  return pointer;
}

std::string shown(const nlohmann::json& value) {
  using nlohmann::json;
  switch (value.type()) {
  case json::value_t::object: return "an object";
  case json::value_t::array: return "an array";
  case json::value_t::string: return in_quotes(value.get_ref<const std::string&>());
  case json::value_t::null: return "null";
  case json::value_t::boolean: return value.get<bool>() ? "true" : "false";
  default: return fmt::format("{}", value.get<double>());
  }
}

bool equal_letters(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

} // namespace kindling::gltf
