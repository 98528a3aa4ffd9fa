// Rows of flags: what their labels mean.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/flag_table.h"

#include <algorithm>
#include <cctype>

namespace kindling::app {

std::vector<std::string> label_choices(const std::string& label) {
  std::vector<std::string> choices;
  for (size_t begin = 0; begin <= label.size();) {
    const size_t end = std::min(label.find('|', begin), label.size());
    choices.push_back(label.substr(begin, end - begin));
    begin = end + 1;
  }
  const auto is_word = [](const std::string& choice) {
    return !choice.empty() && std::all_of(choice.begin(), choice.end(), [](unsigned char c) {
      return std::islower(c) != 0 || std::isdigit(c) != 0 || c == '-';
    });
  };
  // Words beside placeholders, as in "env|R,G,B", are choices; the placeholders are left out.
  std::erase_if(choices, [&](const std::string& choice) { return !is_word(choice); });
  return label.find('|') == std::string::npos ? std::vector<std::string>() : choices;
}

bool label_is_path(const std::string& label) {
  return label == "FILE" || label == "DIR" || label == "FOLDER" || label == "CONFIG" || label.starts_with("FILE[");
}

} // namespace kindling::app
