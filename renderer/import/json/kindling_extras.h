// Reads the object "kindling" in the `extras` of a glTF element.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/import/files/failure.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::gltf {

// Errors in it never stop the import: keys that are unknown, of a wrong type or out of range are
// ignored with a warning (place, value, accepted values). Read every supported key, then call
// finish().
class KindlingExtras {
 public:
  // `element` and `warnings` must outlive this object; `pointer` is the element's JSON pointer. An
  // element without extras has no keys.
  KindlingExtras(const nlohmann::json& element, const std::string& pointer, Warnings& warnings);

  // The numbers that a key accepts; `accepted` describes them: "a number above 0".
  struct Range {
    double min;
    double max;
    bool above_min = false; // `min` itself is excluded
    std::string_view accepted;
  };
  [[nodiscard]] std::optional<float> number(const char* key, const Range& range);
  [[nodiscard]] std::optional<int> integer(const char* key, const Range& range);
  [[nodiscard]] std::optional<V2f> pair(const char* key, const Range& range); // an array of two
  [[nodiscard]] std::optional<std::string> text(const char* key);             // not empty
  [[nodiscard]] std::optional<bool> flag(const char* key);
  // Warns that the value of a key is ignored, for a reason outside of the value.
  void warn(const char* key, std::string_view accepted);
  // Warns of keys that were never read.
  void finish();

 private:
  [[nodiscard]] const nlohmann::json* find(const char* key);

  const nlohmann::json* object_ = nullptr;
  std::string pointer_;
  Warnings& warnings_;
  std::vector<std::string_view> known_;
};

} // namespace kindling::gltf
