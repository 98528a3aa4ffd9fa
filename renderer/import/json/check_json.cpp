// Validates a JSON tree against the schema, recursively from the root.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/check_json.h"

#include "renderer/import/json/json_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kindling::gltf {
namespace {

using nlohmann::json;

std::string shown(const json& value) {
  switch (value.type()) {
  case json::value_t::object: return "an object";
  case json::value_t::array: return "an array";
  case json::value_t::string: return in_quotes(value.get_ref<const std::string&>());
  case json::value_t::null: return "null";
  case json::value_t::boolean: return value.get<bool>() ? "true" : "false";
  default: return fmt::format("{}", value.get<double>());
  }
}

class Checker {
 public:
  Checker(json& root, Warnings& warnings) : root_(root), warnings_(warnings) {}

  CorePlaces run() {
    if (!root_.is_object()) fail_here(fmt::format("{} at the top, expected an object", shown(root_)), "TYPE_MISMATCH");
    check_object(root_, kGltfSchema, true);
    return std::move(places_);
  }

 private:
  [[noreturn]] void fail_here(std::string_view message, std::string_view code) const {
    fail(pointer_here(), message, code);
  }

  [[nodiscard]] std::string pointer_here() const {
    std::string pointer;
    for (const auto& step : path_) {
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

  [[noreturn]] void fail_type(const json& value, std::string_view accepted) const {
    fail_here(fmt::format("{}, expected {}", shown(value), accepted), "TYPE_MISMATCH");
  }

  void check_object(json& value, const JsonSchema& schema, bool core) {
    if (!value.is_object()) fail_type(value, "an object");
    for (const JsonProperty& property : schema.properties) {
      const auto found = value.find(property.name);
      if (found == value.end()) {
        if (property.required) {
          fail_here(fmt::format("'{}' is missing", property.name), "UNDEFINED_PROPERTY");
        }
        if (core) note_absent(value, property, schema);
        continue;
      }
      path_.emplace_back(property.name);
      if (property.soft && points_nowhere(*found, property)) {
        warnings_.add("soft", pointer_here(),
                      fmt::format("{} is not an index of the {} {}", shown(*found),
                                  collection_size(property.collection), property.collection),
                      "UNRESOLVED_REFERENCE");
        value.erase(found);
        path_.pop_back();
        continue;
      }
      if (core && !property.core) places_.hidden.push_back(&*found);
      check_property(*found, property, core && property.core);
      path_.pop_back();
    }
    if (core) {
      for (const char* name : {"extensions", "extras"}) {
        if (const auto found = value.find(name); found != value.end()) places_.hidden.push_back(&*found);
      }
    }
    check_extensions(value, schema);
  }

  // Absent properties that tinygltf 2.7 requires.
  void note_absent(json& value, const JsonProperty& property, const JsonSchema& schema) {
    if (&schema == &kAccessorSchema && property.name == "bufferView") {
      places_.accessors_without_view.push_back(&value);
    } else if (&schema == &kChannelTargetSchema && property.name == "node") {
      places_.targets_without_node.push_back(&value);
    }
  }

  void check_extensions(json& value, const JsonSchema& schema) {
    const auto extensions = value.find("extensions");
    if (extensions == value.end()) return;
    path_.emplace_back(std::string_view("extensions"));
    if (!extensions->is_object()) fail_type(*extensions, "an object");
    for (const JsonExtension& extension : schema.extensions) {
      const auto found = extensions->find(extension.name);
      if (found == extensions->end()) continue;
      path_.emplace_back(extension.name);
      check_object(*found, *extension.schema, false);
      path_.pop_back();
    }
    path_.pop_back();
  }

  void check_property(json& value, const JsonProperty& property, bool core) {
    if (!property.array) {
      check_value(value, property, core);
      return;
    }
    if (!value.is_array()) fail_type(value, "an array");
    if (value.size() < property.min_items || value.size() > property.max_items) {
      const std::string accepted = property.max_items == UINT32_MAX ? fmt::format("at least {}", property.min_items)
                                                                    : fmt::format("{}", property.max_items);
      fail_here(fmt::format("{} elements, expected {}", value.size(), accepted),
                value.empty() ? "EMPTY_ENTITY" : "ARRAY_LENGTH_NOT_IN_LIST");
    }
    for (size_t i = 0; i < value.size(); ++i) {
      path_.emplace_back(i);
      check_value(value[i], property, core);
      path_.pop_back();
    }
  }

  void check_value(json& value, const JsonProperty& property, bool core) {
    switch (property.kind) {
    case JsonKind::boolean:
      if (!value.is_boolean()) fail_type(value, "true or false");
      break;
    case JsonKind::integer: check_integer(value, property); break;
    case JsonKind::index: check_index(value, property); break;
    case JsonKind::number: check_number(value, property); break;
    case JsonKind::string:
      if (!value.is_string()) fail_type(value, "a string");
      break;
    case JsonKind::choice: check_choice(value, property); break;
    case JsonKind::code: check_code(value, property); break;
    case JsonKind::object:
      if (property.schema != nullptr) {
        check_object(value, *property.schema, core);
      } else if (!value.is_object()) {
        fail_type(value, "an object");
      }
      break;
    case JsonKind::index_map: check_index_map(value, property); break;
    }
  }

  int64_t check_whole(json& value) const {
    if (value.is_number_float()) {
      const double number = value.get<double>();
      if (!(std::abs(number) <= 9007199254740991.0) || number != std::trunc(number)) fail_type(value, "an integer");
      value = static_cast<int64_t>(number);
    }
    if (!value.is_number_integer()) fail_type(value, "an integer");
    if (value.is_number_unsigned() && value.get<uint64_t>() > (1ULL << 53)) {
      fail_here(fmt::format("{}, expected an integer below 2^53", value.get<uint64_t>()), "VALUE_NOT_IN_RANGE");
    }
    const auto number = value.get<int64_t>();
    if (number >= 0 && !value.is_number_unsigned())
      value = static_cast<uint64_t>(number); // tinygltf reads sizes from unsigned values only
    return number;
  }

  void check_integer(json& value, const JsonProperty& property) const {
    const int64_t number = check_whole(value);
    if (static_cast<double>(number) < property.min || static_cast<double>(number) > property.max) {
      fail_here(fmt::format("{}, expected {:.0f} to {:.0f}", number, property.min, property.max), "VALUE_NOT_IN_RANGE");
    }
    if (property.multiple_of > 1 && number % property.multiple_of != 0) {
      fail_here(fmt::format("{}, expected a multiple of {}", number, property.multiple_of), "VALUE_MULTIPLE_OF");
    }
  }

  [[nodiscard]] size_t collection_size(std::string_view name) const {
    const auto found = root_.find(name);
    return found != root_.end() && found->is_array() ? found->size() : 0;
  }

  [[nodiscard]] bool points_nowhere(const json& value, const JsonProperty& property) const {
    return value.is_number_integer() &&
           (value.get<int64_t>() < 0 || value.get<uint64_t>() >= collection_size(property.collection));
  }

  void check_index(json& value, const JsonProperty& property) const {
    const int64_t index = check_whole(value);
    const size_t size = collection_size(property.collection);
    if (index < 0 || static_cast<uint64_t>(index) >= size) {
      const std::string accepted = size == 0
                                       ? fmt::format("there are no {}", property.collection)
                                       : fmt::format("expected an index of {}, 0 to {}", property.collection, size - 1);
      fail_here(fmt::format("{}, {}", index, accepted), "UNRESOLVED_REFERENCE");
    }
  }

  void check_number(json& value, const JsonProperty& property) const {
    if (!value.is_number()) fail_type(value, "a number");
    double number = value.get<double>();
    const double slack = property.max < FLT_MAX ? 1e-4 * (property.max - property.min) : 0.0;
    const bool low = property.above_min ? number <= property.min : number < property.min - slack;
    if (low || !(number <= property.max + slack)) {
      const std::string min =
          property.min <= -FLT_MAX ? "" : fmt::format(" {} {}", property.above_min ? "above" : "from", property.min);
      const bool bounded = property.max < FLT_MAX;
      const std::string max = bounded ? fmt::format(" to {}", property.max) : "";
      fail_here(fmt::format("{}, expected a {}number{}{}", number, bounded ? "" : "finite ", min, max),
                "VALUE_NOT_IN_RANGE");
    }
    if (number < property.min || number > property.max) {
      number = std::clamp(number, property.min, property.max);
      value = number;
    }
  }

  void check_choice(json& value, const JsonProperty& property) const {
    if (!value.is_string()) fail_type(value, "a string");
    const auto& text = value.get_ref<const std::string&>();
    if (std::find(property.choices.begin(), property.choices.end(), text) == property.choices.end()) {
      fail_here(fmt::format("{}, expected one of {}", in_quotes(text), fmt::join(property.choices, ", ")),
                "VALUE_NOT_IN_LIST");
    }
  }

  void check_code(json& value, const JsonProperty& property) const {
    const int64_t code = check_whole(value);
    if (std::find(property.codes.begin(), property.codes.end(), code) == property.codes.end()) {
      fail_here(fmt::format("{}, expected one of {}", code, fmt::join(property.codes, ", ")), "VALUE_NOT_IN_LIST");
    }
  }

  void check_index_map(json& value, const JsonProperty& property) {
    if (!value.is_object()) fail_type(value, "an object");
    for (auto& [name, index] : value.items()) {
      path_.emplace_back(std::string_view(name));
      check_index(index, property);
      path_.pop_back();
    }
  }

  json& root_;
  Warnings& warnings_;
  CorePlaces places_;
  std::vector<std::variant<std::string_view, size_t>> path_;
};

} // namespace

CorePlaces check_json(json& root, Warnings& warnings) { return Checker(root, warnings).run(); }

} // namespace kindling::gltf
