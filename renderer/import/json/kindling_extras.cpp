// Typed values of Kindling's extras, with warnings for invalid ones.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/kindling_extras.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kindling::gltf {
namespace {

using nlohmann::json;

bool in_range(const json& value, const KindlingExtras::Range& range) {
  if (!value.is_number()) return false;
  const double number = value.get<double>();
  // Smaller numbers are denormal or 0 in single precision.
  if (number != 0.0 && std::abs(number) < static_cast<double>(std::numeric_limits<float>::min())) return false;
  return std::isfinite(number) && number <= range.max && (range.above_min ? number > range.min : number >= range.min);
}

std::string shown_value(const json& value) {
  return in_quotes(value.dump(-1, ' ', true, json::error_handler_t::replace));
}

} // namespace

KindlingExtras::KindlingExtras(const json& element, const std::string& pointer, Warnings& warnings)
    : pointer_(pointer + "/extras/kindling"), warnings_(warnings) {
  const auto extras = element.find("extras");
  if (extras == element.end() || !extras->is_object()) return; // other applications may store anything there
  const auto own = extras->find("kindling");
  if (own == extras->end()) return;
  if (own->is_object()) {
    object_ = &*own;
  } else {
    warnings_.add("extras", pointer_, shown_value(*own) + " is ignored, expected an object");
  }
}

const json* KindlingExtras::find(const char* key) {
  known_.emplace_back(key);
  if (object_ == nullptr) return nullptr;
  const auto found = object_->find(key);
  return found == object_->end() ? nullptr : &*found;
}

std::optional<float> KindlingExtras::number(const char* key, const Range& range) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (in_range(*value, range)) return value->get<float>();
  warn(key, range.accepted);
  return std::nullopt;
}

std::optional<int> KindlingExtras::integer(const char* key, const Range& range) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (in_range(*value, range) && value->get<double>() == std::floor(value->get<double>()))
    return static_cast<int>(value->get<double>());
  warn(key, range.accepted);
  return std::nullopt;
}

std::optional<V2f> KindlingExtras::pair(const char* key, const Range& range) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_array() && value->size() == 2 && in_range((*value)[0], range) && in_range((*value)[1], range))
    return V2f((*value)[0].get<float>(), (*value)[1].get<float>());
  warn(key, range.accepted);
  return std::nullopt;
}

std::optional<std::string> KindlingExtras::text(const char* key) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_string() && !value->get_ref<const std::string&>().empty()) return value->get<std::string>();
  warn(key, "a text that is not empty");
  return std::nullopt;
}

std::optional<bool> KindlingExtras::flag(const char* key) {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (value->is_boolean()) return value->get<bool>();
  warn(key, "true or false");
  return std::nullopt;
}

void KindlingExtras::warn(const char* key, std::string_view accepted) {
  warnings_.add(fmt::format("extras {}", key), fmt::format("{}/{}", pointer_, key),
                fmt::format("{} is ignored, expected {}", shown_value((*object_)[key]), accepted));
}

void KindlingExtras::finish() {
  if (object_ == nullptr) return;
  for (const auto& [key, value] : object_->items()) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string names;
    for (const std::string_view name : known_) names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
    warnings_.add("extras of an unknown name", pointer_,
                  fmt::format("{} is ignored, expected one of {}", in_quotes(key), names));
  }
}

} // namespace kindling::gltf
