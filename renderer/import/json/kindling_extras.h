// What Kindling reads from a file beside glTF's own properties: the object "kindling" in the `extras` of an element.
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

// Nothing in it stops the import: what is unknown, of a wrong type or out of range is ignored, with a warning that names the place,
// the value and what is accepted. Read every key that exists, then call finish().
class KindlingExtras {
 public:
  // `element` and `warnings` must outlive it; `pointer` is the element's JSON pointer. Elements without such an object have no keys.
  KindlingExtras(const nlohmann::json& element, const std::string& pointer, Warnings& warnings);

  // Which numbers a key accepts, in words too: "a number above 0".
  struct Range {
    double min;
    double max;
    bool above_min = false; // `min` itself is excluded
    std::string_view accepted;
  };
  [[nodiscard]] std::optional<float> number(const char* key, const Range& range);
  [[nodiscard]] std::optional<int> integer(const char* key, const Range& range);
  [[nodiscard]] std::optional<V2f> pair(const char* key, const Range& range); // an array of two
  // Complains about the value of a key that was read, for reasons that lie outside of it.
  void warn(const char* key, std::string_view accepted);
  // Warns of the keys that were not asked for.
  void finish();

 private:
  [[nodiscard]] const nlohmann::json* find(const char* key);

  const nlohmann::json* object_ = nullptr;
  std::string pointer_;
  Warnings& warnings_;
  std::vector<std::string_view> known_;
};

} // namespace kindling::gltf
