// Replaces JSON numbers beyond the range of double.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/files/number_range.h"

#include <algorithm>
#include <charconv>

namespace kindling::gltf {

namespace {

bool is_number_character(char c) {
  return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == 'e' || c == 'E';
}

// Returns whether a number is too large, instead of too small or no number.
bool overflows(std::string_view number) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (error != std::errc::result_out_of_range || end != number.data() + number.size()) return false;
  const size_t exponent = number.find_first_of("eE");
  return exponent == std::string_view::npos || number.substr(exponent + 1, 1) != "-";
}

} // namespace

std::string limit_numbers(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (size_t at = 0; at < text.size();) {
    size_t end = at + 1;
    if (text[at] == '"') {
      while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
      end = std::min(end + 1, text.size());
    } else if (text[at] == '-' || (text[at] >= '0' && text[at] <= '9')) {
      while (end < text.size() && is_number_character(text[end])) ++end;
      if (overflows(text.substr(at, end - at))) {
        result += text[at] == '-' ? "-1.7976931348623157e308" : "1.7976931348623157e308";
        at = end;
        continue;
      }
    }
    result += text.substr(at, end - at);
    at = end;
  }
  return result;
}

} // namespace kindling::gltf
