// The schema of glTF's JSON as data: properties of each object with types and ranges.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cfloat>
#include <cstdint>
#include <span>
#include <string_view>

namespace kindling::gltf {

enum class JsonKind : uint8_t {
  boolean,
  integer, // also accepted when written as 2.0
  index,   // an integer below the length of the root array `collection`
  number,  // finite as a float
  string,
  choice,    // one of `choices`
  code,      // an integer of `codes`
  object,    // conforms to `schema`
  index_map, // an object whose values are indices
};

// The repair of a faulty property, with a warning, in loads that are not strict. Structure that
// geometry depends on is refused.
enum class JsonRepair : uint8_t {
  refuse,
  clamp,  // a number takes the nearest accepted value, a list loses its excess; else as `ignore`
  ignore, // the property is removed, so its default applies; choices match in any case of letters
  skip,   // array: faulty elements are removed
  // Array: a faulty element becomes `stand_in`. Nodes lose their reference to it; a used mesh, skin
  // or accessor is refused after all.
  replace,
};

struct JsonSchema;

struct JsonProperty {
  std::string_view name;
  JsonKind kind = JsonKind::number;
  bool required = false;
  bool array = false; // an array of that kind
  uint32_t min_items = 0;
  uint32_t max_items = UINT32_MAX;
  double min = -FLT_MAX;
  double max = FLT_MAX;
  bool above_min = false; // `min` itself is excluded
  uint32_t multiple_of = 1;
  std::string_view collection;
  std::span<const std::string_view> choices;
  std::span<const int> codes;
  const JsonSchema* schema = nullptr;
  bool soft = false; // index: removed with a warning if it is out of bounds
  bool core = true;  // read by tinygltf; false: hidden from it and read from the JSON
  JsonRepair repair = JsonRepair::refuse;
  // Numbers outside of [min, max] that are used unchanged, with a warning; an empty range: none.
  double lenient_min = 1.0;
  double lenient_max = 0.0;
  // JSON text: the element of JsonRepair::replace, or the value of a required property that is
  // missing or faulty under JsonRepair::ignore.
  std::string_view stand_in;
};

// An extension object below "extensions" of an object.
struct JsonExtension {
  std::string_view name;
  const JsonSchema* schema = nullptr;
  JsonRepair repair = JsonRepair::refuse; // or ignore
};

struct JsonSchema {
  std::span<const JsonProperty> properties;
  std::span<const JsonExtension> extensions;
};

// Schema of the root of a glTF 2.0 file (specification, section 5) with the extensions that the
// importer reads. Other properties are not checked.
extern const JsonSchema kGltfSchema;
// Named because check_json() records their absent properties in CorePlaces.
extern const JsonSchema kAccessorSchema;
extern const JsonSchema kChannelTargetSchema;
// Named because the object that its type names must exist.
extern const JsonSchema kCameraSchema;

} // namespace kindling::gltf
