// Mutations of a tree of JSON values.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutators/mutate_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <vector>

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace kindling::fuzz {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMaxDepth = 100;

bool nested_deeper(std::string_view text, int levels) {
  int depth = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > levels) return true;
  }
  return false;
}

// Pointers to every value below `value`, itself included, and the names of all members.
struct Places {
  std::vector<Json*> values;
  std::vector<std::string> names;
};

void collect(Json& value, Places& places) {
  places.values.push_back(&value);
  if (value.is_object())
    for (auto& [name, member] : value.items()) {
      places.names.push_back(name);
      collect(member, places);
    }
  if (value.is_array())
    for (Json& element : value) collect(element, places);
}

Json other_number(const Json& value, Random& random) {
  static const std::array<Json, 30> kNumbers = {
      0,    1,     2,     3,     4,     5,           7,          8,          16,       64,
      255,  256,   65535, 65536, 5121,  2147483647u, -1,         -2,         -128,     0.5,
      -0.0, 1e-30, 1e30,  3e38,  1e308, -1e18,       4294967295, 4294967296, 1u << 20, UINT64_MAX};
  if (value.is_number_integer() && random.one_in(2)) {
    const int64_t before = value.get<int64_t>();
    constexpr std::array<int64_t, 6> kSteps = {1, -1, 2, -4, 8, 100};
    if (before > -(int64_t{1} << 60) && before < (int64_t{1} << 60))
      return before + kSteps[random.below(kSteps.size())];
  }
  if (value.is_number_float() && random.one_in(3)) return -value.get<double>();
  if (value.is_number_float() && random.one_in(3)) return 1000.0 * value.get<double>();
  return kNumbers[random.below(kNumbers.size())];
}

Json other_kind(Random& random) {
  static const std::array<Json, 10> kValues = {nullptr, true, false, Json::array(),          Json::object(),
                                               "",      0,    1.5,   Json::array({0, 1, 2}), "x"};
  return kValues[random.below(kValues.size())];
}

// Removes, copies or renames a child of an object or array.
void change_children(Json& value, const Places& places, Random& random) {
  if (value.empty()) {
    if (value.is_array()) value.push_back(*places.values[random.below(places.values.size())]);
    return;
  }
  const size_t index = random.below(value.size());
  if (value.is_array()) {
    const auto place = value.begin() + static_cast<std::ptrdiff_t>(index);
    switch (random.below(4)) {
    case 0: value.erase(place); break;
    case 1: value.insert(place, Json(*place)); break;
    case 2: std::iter_swap(place, value.begin()); break;
    default: value.push_back(Json(*places.values[random.below(places.values.size())]));
    }
    return;
  }
  auto place = value.begin();
  std::advance(place, index);
  const std::string name = place.key();
  switch (random.below(3)) {
  case 0: value.erase(place); break;
  case 1: { // under another name of the text
    Json member = *place;
    if (random.one_in(2)) value.erase(place);
    if (!places.names.empty()) value[places.names[random.below(places.names.size())]] = std::move(member);
    break;
  }
  default: value[name] = Json(*places.values[random.below(places.values.size())]);
  }
}

void change(Json& root, size_t max_size, Random& random) {
  Places places;
  collect(root, places);
  Json& value = *places.values[random.below(places.values.size())];
  const size_t choice = random.below(12);
  if (choice == 0) {
    value = other_kind(random);
  } else if (choice == 1) {
    value = Json(*places.values[random.below(places.values.size())]); // a copy: it may be a parent
  } else if (value.is_structured()) {
    change_children(value, places, random);
  } else if (value.is_number()) {
    value = other_number(value, random);
  } else if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    const Json& other = *places.values[random.below(places.values.size())];
    value = other.is_string() && random.one_in(3) ? other
                                                  : Json(mutate_bytes(text, std::min(max_size, 2 * text.size() + 64)));
  } else {
    value = value.is_boolean() && random.one_in(2) ? Json(!value.get<bool>()) : other_kind(random);
  }
}

} // namespace

std::string mutate_bytes(std::string_view bytes, size_t max_size) {
  std::string result(bytes.substr(0, max_size));
  const size_t before = result.size();
  result.resize(std::max<size_t>(max_size, 1));
  result.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(result.data()), before, result.size()));
  return result;
}

std::string mutate_json(std::string_view text, size_t max_size, Random& random) {
  if (random.one_in(8) || nested_deeper(text, kMaxDepth)) return mutate_bytes(text, max_size);
  Json root = Json::parse(text.begin(), text.end(), nullptr, false);
  if (root.is_discarded()) return mutate_bytes(text, max_size);
  for (size_t i = 0, count = 1 + random.below(4); i < count; ++i) change(root, max_size, random);
  std::string result = root.dump(-1, ' ', false, Json::error_handler_t::replace);
  return result.size() <= max_size ? result : mutate_bytes(text, max_size);
}

} // namespace kindling::fuzz
