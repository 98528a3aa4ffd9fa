// Text for messages of one line: control characters replaced, lists of choices.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

namespace text_detail {

// Returns the length of the UTF-8 sequence at the front of `text`, which is not empty, and its code
// point; 1 and the byte itself if it is none.
struct CodePoint {
  size_t bytes = 1;
  uint32_t value = 0;
};
[[nodiscard]] inline CodePoint first_code_point(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<uint32_t>(static_cast<unsigned char>(text[i])); };
  const uint32_t lead = byte(0);
  const size_t length = lead >= 0xc2 && lead < 0xe0 ? 2 : (lead & 0xf0U) == 0xe0 ? 3 : (lead & 0xf8U) == 0xf0 ? 4 : 1;
  if (length == 1 || text.size() < length) return {1, lead};
  uint32_t value = lead & (0xffU >> (length + 1));
  for (size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return {1, lead};
    value = value << 6 | (byte(i) & 0x3fU);
  }
  return {length, value};
}

// Returns whether a terminal obeys a code point, or a byte that is not UTF-8, instead of showing
// it: C0, DEL, C1, and the marks that reverse the order of the text after them.
[[nodiscard]] inline bool is_control(uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x2028 || c == 0x2029 || (c >= 0x202a && c <= 0x202e) ||
         (c >= 0x2066 && c <= 0x2069);
}

} // namespace text_detail

// Returns the text with control characters, which a terminal would obey, as '?' and line breaks as
// spaces. Other bytes that are not UTF-8 are kept.
[[nodiscard]] inline std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const text_detail::CodePoint first = text_detail::first_code_point(text);
    if (first.value == '\n' || first.value == '\r' || first.value == '\t')
      result += ' ';
    else if (text_detail::is_control(first.value))
      result += '?';
    else
      result += text.substr(0, first.bytes);
    text.remove_prefix(first.bytes);
  }
  return result;
}

// The same for text of several lines: line feeds and tabs are kept.
[[nodiscard]] inline std::string printable_lines(std::string_view text) {
  std::string result;
  while (true) {
    const size_t end = text.find_first_of("\n\t");
    result += printable(text.substr(0, end));
    if (end == std::string_view::npos) return result;
    result += text[end];
    text.remove_prefix(end + 1);
  }
}

// Returns "a, b or c".
[[nodiscard]] inline std::string join_choices(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text;
}

} // namespace kindling
