// Commands and flags of the program as rows of text, for the manual page and the completions.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace kindling::app {

struct FlagRow {
  std::string short_name;  // "-o"; empty: none
  std::string long_name;   // "--output"
  std::string label;       // stands for the value: "FILE", "on|off"; empty: the flag takes none
  std::string description; // one line, with unit and [default]
  std::string group;       // the heading that it stands under
};

struct CommandTable {
  std::string name;        // "render", "farm submit"
  std::string usage;       // "SCENE [-o FILE]... [flags]"
  std::string description; // one sentence
  std::vector<FlagRow> flags;
};

// The words of "keep|trim", if the label is a list of words to choose from; else none.
[[nodiscard]] std::vector<std::string> label_choices(const std::string& label);
// True if the label stands for the name of a file or folder.
[[nodiscard]] bool label_is_path(const std::string& label);

} // namespace kindling::app
