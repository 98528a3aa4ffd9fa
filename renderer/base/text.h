// Text for messages of one line: control characters replaced, lists of choices.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Returns the text with control characters, which a terminal would obey, as '?' and line breaks as
// spaces. Bytes that are not UTF-8 are kept.
[[nodiscard]] inline std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool c1_control = c == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) >= 0x80 &&
                            static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (c1_control) {
      result += '?';
      ++i;
    } else if (c == '\n' || c == '\r' || c == '\t') {
      result += ' ';
    } else if (c < 0x20 || c == 0x7f) {
      result += '?';
    } else {
      result += text[i];
    }
  }
  return result;
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
