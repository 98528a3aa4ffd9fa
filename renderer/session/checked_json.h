// Values of JSON that is not trusted: each is checked, and Unsound describes what is wrong with it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/json_text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace kindling::checked {

using Json = nlohmann::ordered_json;

inline constexpr int kMaxSide = 1 << 20; // of an image, pixels
inline constexpr int kMaxJsonDepth = 64; // of texts that are JSON; their readers recurse

// A value that is missing, or not what is wanted.
struct Unsound : std::runtime_error {
  using std::runtime_error::runtime_error;
};
[[noreturn]] inline void unsound(std::string_view key, std::string_view wanted) {
  throw Unsound(fmt::format("'{}' is not {}", key, wanted));
}

[[nodiscard]] inline std::string text_from_json(const Json& json, std::string_view key) {
  std::optional<std::string> text = kindling::text_from_json(json);
  if (!text) unsound(key, "a text");
  return *std::move(text);
}

[[nodiscard]] inline const Json& member(const Json& object, const char* key) {
  if (!object.is_object()) throw Unsound(fmt::format("the value that should have '{}' is not an object", key));
  const auto found = object.find(key);
  if (found == object.end()) throw Unsound(fmt::format("'{}' is missing", key));
  return *found;
}

[[nodiscard]] inline uint64_t whole(const Json& json, std::string_view key, uint64_t largest) {
  if (!json.is_number_unsigned() || json.get<uint64_t>() > largest)
    unsound(key, fmt::format("a whole number up to {}", largest));
  return json.get<uint64_t>();
}

template <typename Number>
void read_whole(const Json& object, const char* key, Number& number) {
  number = static_cast<Number>(whole(member(object, key), key, std::numeric_limits<Number>::max()));
}

[[nodiscard]] inline double number(const Json& object, const char* key, double max, std::string_view wanted) {
  const Json& json = member(object, key);
  if (!json.is_number() || !(json.get<double>() >= 0.0 && json.get<double>() <= max)) unsound(key, wanted);
  return json.get<double>();
}

[[nodiscard]] inline double seconds(const Json& object, const char* key) {
  return number(object, key, std::numeric_limits<double>::infinity(), "a time in seconds");
}

[[nodiscard]] inline std::string text(const Json& object, const char* key) {
  return text_from_json(member(object, key), key);
}

// Returns a text of the file for a message: short, without bytes that a terminal would obey.
[[nodiscard]] inline std::string in_quotes(std::string_view text) {
  constexpr size_t kShown = 40;
  return Json(std::string(text.substr(0, kShown))).dump(-1, ' ', true, Json::error_handler_t::replace);
}

[[nodiscard]] inline std::string json_text(const Json& object, const char* key) {
  std::string json = text(object, key);
  if (json_depth(json) > kMaxJsonDepth) unsound(key, fmt::format("JSON of at most {} levels", kMaxJsonDepth));
  return json;
}

[[nodiscard]] inline bool flag(const Json& object, const char* key) {
  const Json& json = member(object, key);
  if (!json.is_boolean()) unsound(key, "true or false");
  return json.get<bool>();
}

[[nodiscard]] inline const Json& list(const Json& object, const char* key) {
  const Json& json = member(object, key);
  if (!json.is_array()) unsound(key, "a list");
  return json;
}

// [width, height], or [x, y, x, y].
template <size_t kCount>
[[nodiscard]] std::array<int, kCount> coordinates(const Json& object, const char* key) {
  const Json& json = list(object, key);
  if (json.size() != kCount) unsound(key, fmt::format("a list of {} numbers", kCount));
  std::array<int, kCount> values{};
  for (size_t i = 0; i < kCount; ++i) values[i] = static_cast<int>(whole(json[i], key, kMaxSide));
  return values;
}

} // namespace kindling::checked
