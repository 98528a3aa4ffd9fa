// The shape of glTF's JSON as data: what each object may hold, of which type and in which range.
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
  object,    // as `schema` says
  index_map, // an object whose every value is an index
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
  bool soft = false; // index: one that points nowhere is dropped with a warning
  bool core = true;  // handed on to tinygltf; false: read from the JSON by this folder
};

// An extension object that may stand under "extensions" of an object.
struct JsonExtension {
  std::string_view name;
  const JsonSchema* schema = nullptr;
};

struct JsonSchema {
  std::span<const JsonProperty> properties;
  std::span<const JsonExtension> extensions;
};

// The root of a glTF 2.0 file (specification, section 5) with the extensions that this folder reads. What it does not
// list is not looked at.
extern const JsonSchema kGltfSchema;
// Recognised by the writer of the core JSON, which adds to them.
extern const JsonSchema kAccessorSchema;
extern const JsonSchema kChannelTargetSchema;

} // namespace kindling::gltf
