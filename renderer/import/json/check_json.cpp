// Validates a JSON tree against the schema, recursively from the root.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/check_json.h"

#include "renderer/import/json/json_path.h"
#include "renderer/import/json/json_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace kindling::gltf {
namespace {

using nlohmann::json;

class Checker {
 public:
  Checker(json& root, Warnings& warnings) : root_(root), warnings_(warnings) {}

  CorePlaces run() {
    if (!root_.is_object()) fail_here(fmt::format("{} at the top, expected an object", shown(root_)), "TYPE_MISMATCH");
    check_object(root_, kGltfSchema, true);
    if (!replaced_.empty()) forget_replaced();
    return std::move(places_);
  }

 private:
  [[noreturn]] void fail_here(std::string_view message, std::string_view code) const {
    throw fault_here(message, code);
  }

  [[noreturn]] void fail_type(const json& value, std::string_view accepted) const {
    fail_here(fmt::format("{}, expected {}", shown(value), accepted), "TYPE_MISMATCH");
  }

  void check_object(json& value, const JsonSchema& schema, bool core) {
    if (!value.is_object()) fail_type(value, "an object");
    for (const JsonProperty& property : schema.properties) {
      const auto found = value.find(property.name);
      if (found == value.end()) {
        if (property.required) supply(value, property);
        if (core) note_absent(value, property, schema);
        continue;
      }
      path_.push(property.name);
      if (property.soft && points_nowhere(*found, property)) {
        warnings_.add("soft", path_.pointer(),
                      fmt::format("{} is not an index of the {} {}", shown(*found),
                                  collection_size(property.collection), property.collection),
                      "UNRESOLVED_REFERENCE");
        value.erase(found);
        path_.pop();
        continue;
      }
      if (!keeps(*found, property, core)) {
        value.erase(found);
        if (has_default(property)) value[property.name] = json::parse(property.stand_in);
        if (core) note_absent(value, property, schema);
      }
      path_.pop();
    }
    if (&schema == &kCameraSchema && !value.contains(value["type"].get_ref<const std::string&>()))
      fail_here(fmt::format("'{}' is missing", value["type"].get_ref<const std::string&>()), "UNDEFINED_PROPERTY");
    check_extensions(value, schema);
    if (core) {
      for (const char* name : {"extensions", "extras"}) {
        if (const auto found = value.find(name); found != value.end()) places_.hidden.push_back(&*found);
      }
    }
  }

  // True for a required property with a stand-in.
  static bool has_default(const JsonProperty& property) {
    return property.required && property.repair == JsonRepair::ignore && !property.stand_in.empty();
  }

  // Adds a missing required property, or refuses the object.
  void supply(json& object, const JsonProperty& property) const {
    const ImportFailure fault = fault_here(fmt::format("'{}' is missing", property.name), "UNDEFINED_PROPERTY");
    if (!has_default(property)) throw fault;
    warnings_.repair(fmt::format("missing {}", property.name), fault, fmt::format("{} is used", property.stand_in));
    object[property.name] = json::parse(property.stand_in);
  }

  // Checks a property of an object; returns false if it must be removed.
  bool keeps(json& value, const JsonProperty& property, bool core) {
    const bool none = !property.required && means_none(value, property);
    const bool refuse =
        !none && (property.repair == JsonRepair::refuse || (property.required && !has_default(property)));
    const std::string remedy = none                    ? "it is read as absent"
                               : has_default(property) ? fmt::format("{} is used", property.stand_in)
                                                       : "it is ignored";
    return attempt(refuse, property.name, remedy, [&] {
      if (core && !property.core) places_.hidden.push_back(&value);
      check_property(value, property, core && property.core);
    });
  }

  // Exporters write null, or -1 for an index, where they mean nothing.
  static bool means_none(const json& value, const JsonProperty& property) {
    return value.is_null() || (property.kind == JsonKind::index && !property.array && !property.soft &&
                               value.is_number_integer() && value.get<int64_t>() == -1);
  }

  // Calls check(); returns false after a fault that is repaired by removing what was checked.
  template <typename Check>
  bool attempt(bool refuse, std::string_view name, std::string_view remedy, const Check& check) {
    if (refuse) {
      check();
      return true;
    }
    const size_t depth = path_.size();
    const std::array sizes = {places_.hidden.size(), places_.accessors_without_view.size(),
                              places_.targets_without_node.size()};
    try {
      check();
      return true;
    } catch (const ImportFailure& failure) {
      warnings_.repair(fmt::format("{} {}", name, remedy), failure, remedy);
      last_fault_ = failure;
    }
    path_.resize(depth);
    places_.hidden.resize(sizes[0]); // pointers into what is removed
    places_.accessors_without_view.resize(sizes[1]);
    places_.targets_without_node.resize(sizes[2]);
    return false;
  }

  // Removes the references of nodes to cameras and lights that have been replaced. Throws the fault
  // of a replaced mesh or skin that a node uses.
  void forget_replaced() {
    const auto nodes = root_.find("nodes");
    if (nodes == root_.end()) return;
    const auto fault_of = [&](const json& object, const char* name, std::string_view collection) {
      const auto index = object.find(name);
      if (index == object.end() || !index->is_number_unsigned()) return replaced_.end();
      return replaced_.find({collection, index->get<size_t>()});
    };
    for (json& node : *nodes) {
      for (const auto& [name, collection] : {std::pair("mesh", "meshes"), std::pair("skin", "skins")}) {
        const auto fault = fault_of(node, name, collection);
        if (fault != replaced_.end()) throw fault->second;
      }
      if (fault_of(node, "camera", "cameras") != replaced_.end()) node.erase("camera");
      const auto extensions = node.find("extensions");
      if (extensions == node.end()) continue;
      const auto light = extensions->find("KHR_lights_punctual");
      if (light != extensions->end() && fault_of(*light, "light", "lights") != replaced_.end())
        extensions->erase(light);
    }
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
    path_.push("extensions");
    const bool fine = attempt(false, "extensions", "they are ignored", [&] {
      if (!extensions->is_object()) fail_type(*extensions, "an object");
    });
    if (!fine) value.erase(extensions);
    if (fine) check_each_extension(*extensions, schema);
    path_.pop();
  }

  void check_each_extension(json& extensions, const JsonSchema& schema) {
    for (const JsonExtension& extension : schema.extensions) {
      const auto found = extensions.find(extension.name);
      if (found == extensions.end()) continue;
      path_.push(extension.name);
      const bool fine = attempt(extension.repair == JsonRepair::refuse, extension.name, "it is ignored",
                                [&] { check_object(*found, *extension.schema, false); });
      if (!fine) extensions.erase(found);
      path_.pop();
    }
  }

  void check_property(json& value, const JsonProperty& property, bool core) {
    if (!property.array) return check_value(value, property, core);
    if (!value.is_array()) fail_type(value, "an array");
    if (property.repair == JsonRepair::clamp) fit_length(value, property);
    if (value.size() < property.min_items || value.size() > property.max_items) throw length_fault(value, property);
    const bool skip = property.repair == JsonRepair::skip;
    const bool replace = property.repair == JsonRepair::replace;
    size_t count = 0;
    for (size_t i = 0; i < value.size(); ++i) {
      path_.push(i);
      const bool fine = attempt(!skip && !replace, property.name, skip ? "the element is ignored" : "it has no effect",
                                [&] { check_value(value[i], property, core); });
      path_.pop();
      if (!fine && replace) {
        replaced_.emplace(std::pair(property.name, i), last_fault_);
        value[i] = json::parse(property.stand_in);
        if (property.schema == &kAccessorSchema) {
          places_.faulty_accessors.emplace(static_cast<int>(i), last_fault_);
          places_.accessors_without_view.push_back(&value[i]);
        }
      }
      if (!fine && skip) continue;
      if (count != i) value[count].swap(value[i]);
      ++count;
    }
    while (value.size() > count) value.erase(value.size() - 1);
  }

  [[nodiscard]] ImportFailure length_fault(const json& value, const JsonProperty& property) const {
    const std::string accepted = property.max_items == UINT32_MAX ? fmt::format("at least {}", property.min_items)
                                                                  : fmt::format("{}", property.max_items);
    const std::string message = fmt::format("{} elements, expected {}", value.size(), accepted);
    const char* code = value.empty() ? "EMPTY_ENTITY" : "ARRAY_LENGTH_NOT_IN_LIST";
    return fault_here(message, code);
  }

  // Drops excess elements; a color without alpha becomes opaque.
  void fit_length(json& value, const JsonProperty& property) const {
    const bool lacks_alpha = property.min_items == 4 && value.size() == 3;
    if (value.size() <= property.max_items && !lacks_alpha) return;
    warnings_.repair(fmt::format("length {}", property.name), length_fault(value, property),
                     lacks_alpha ? "alpha is 1" : "the last ones are ignored");
    if (lacks_alpha) value.push_back(1.0);
    while (value.size() > property.max_items) value.erase(value.size() - 1);
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

  [[nodiscard]] ImportFailure fault_here(std::string_view message, std::string_view code) const {
    return {{ErrorKind::scene_invalid, place_message(path_.pointer(), message, code)}};
  }

  static bool is_lenient(double number, const JsonProperty& p) {
    return number >= p.lenient_min && number <= p.lenient_max;
  }

  void keep(const ImportFailure& fault, const JsonProperty& property) const {
    warnings_.repair(fmt::format("unchanged {}", property.name), fault, "it is used unchanged");
  }

  void check_integer(json& value, const JsonProperty& property) {
    const int64_t number = check_whole(value);
    const bool outside = static_cast<double>(number) < property.min || static_cast<double>(number) > property.max;
    if (!outside && (property.multiple_of <= 1 || number % property.multiple_of == 0)) return;
    const ImportFailure fault =
        outside ? fault_here(fmt::format("{}, expected {:.0f} to {:.0f}", number, property.min, property.max),
                             "VALUE_NOT_IN_RANGE")
                : fault_here(fmt::format("{}, expected a multiple of {}", number, property.multiple_of),
                             "VALUE_MULTIPLE_OF");
    if (!is_lenient(static_cast<double>(number), property)) throw fault;
    keep(fault, property);
    if (property.multiple_of > 1) places_.hidden.push_back(&value); // tinygltf refuses the file for it
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
    const bool bounded = property.max < FLT_MAX;
    const double slack = bounded ? 1e-4 * (property.max - property.min) : 0.0;
    const bool low = property.above_min ? number <= property.min : number < property.min - slack;
    if (low || !(number <= property.max + slack)) {
      const std::string min =
          property.min <= -FLT_MAX ? "" : fmt::format(" {} {}", property.above_min ? "above" : "from", property.min);
      const std::string max = bounded ? fmt::format(" to {}", property.max) : "";
      const ImportFailure fault = fault_here(
          fmt::format("{}, expected a {}number{}{}", number, bounded ? "" : "finite ", min, max), "VALUE_NOT_IN_RANGE");
      if (is_lenient(number, property)) return keep(fault, property);
      if (property.repair != JsonRepair::clamp || (low ? property.above_min : !bounded)) throw fault;
      warnings_.repair(fmt::format("clamped {}", property.name), fault,
                       fmt::format("{} is used", low ? property.min : property.max));
    }
    if (number < property.min || number > property.max) {
      number = std::clamp(number, property.min, property.max);
      value = number;
    }
  }

  void check_choice(json& value, const JsonProperty& property) const {
    if (!value.is_string()) fail_type(value, "a string");
    const auto& text = value.get_ref<const std::string&>();
    if (std::find(property.choices.begin(), property.choices.end(), text) != property.choices.end()) return;
    const ImportFailure fault = fault_here(
        fmt::format("{}, expected one of {}", in_quotes(text), fmt::join(property.choices, ", ")), "VALUE_NOT_IN_LIST");
    const auto meant = std::find_if(property.choices.begin(), property.choices.end(),
                                    [&](std::string_view choice) { return equal_letters(choice, text); });
    if (property.repair == JsonRepair::refuse || meant == property.choices.end()) throw fault;
    warnings_.repair(fmt::format("letters {}", property.name), fault, fmt::format("{} is used", *meant));
    value = *meant;
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
      path_.push(std::string_view(name));
      check_index(index, property);
      path_.pop();
    }
  }

  json& root_;
  Warnings& warnings_;
  CorePlaces places_;
  JsonPath path_;
  std::map<std::pair<std::string_view, size_t>, ImportFailure> replaced_; // by array's name and index
  ImportFailure last_fault_;                                              // that attempt() has repaired
};

} // namespace

CorePlaces check_json(json& root, Warnings& warnings) { return Checker(root, warnings).run(); }

} // namespace kindling::gltf
