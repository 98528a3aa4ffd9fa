// The place of a value in a JSON tree, and values as errors show them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kindling::gltf {

// The steps from the root to a value. Names are borrowed.
class JsonPath {
 public:
  void push(std::string_view name) { steps_.emplace_back(name); }
  void push(size_t index) { steps_.emplace_back(index); }
  void pop() { steps_.pop_back(); }
  [[nodiscard]] size_t size() const { return steps_.size(); }
  void resize(size_t size) { steps_.resize(size); }
  [[nodiscard]] std::string pointer() const; // RFC 6901; control characters become '?'

 private:
  std::vector<std::variant<std::string_view, size_t>> steps_;
};

// Returns a value for an error message: "an object", "'text'", "0.5".
[[nodiscard]] std::string shown(const nlohmann::json& value);

// Returns true if the texts differ in the case of ASCII letters at most.
[[nodiscard]] bool equal_letters(std::string_view a, std::string_view b);

} // namespace kindling::gltf
