// Completion for bash and zsh: commands, flags, words to choose from, files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

namespace kindling::app {

namespace {

// The first words of the commands, each once: "render", "farm".
std::vector<std::string> first_words(std::span<const CommandTable> commands) {
  std::vector<std::string> words;
  std::set<std::string> seen;
  for (const CommandTable& command : commands) {
    const std::string word = command.name.substr(0, command.name.find(' '));
    if (seen.insert(word).second) words.push_back(word);
  }
  return words;
}

// The second words of the commands that begin with `first`: "submit", "status".
std::vector<std::string> second_words(std::span<const CommandTable> commands, const std::string& first) {
  std::vector<std::string> words;
  for (const CommandTable& command : commands)
    if (command.name.starts_with(first + ' ')) words.push_back(command.name.substr(first.size() + 1));
  return words;
}

std::string flag_names(const CommandTable& command) {
  std::string names;
  for (const FlagRow& flag : command.flags) {
    if (!flag.short_name.empty()) names += flag.short_name + ' ';
    names += flag.long_name + ' ';
  }
  if (!names.empty()) names.pop_back();
  return names;
}

// "-o|--output", as a pattern of bash's case.
std::string pattern(const FlagRow& flag) {
  return flag.short_name.empty() ? flag.long_name : flag.short_name + '|' + flag.long_name;
}

// The lines of bash that complete the value of each flag of a command.
std::string bash_values(const CommandTable& command) {
  std::string lines;
  for (const FlagRow& flag : command.flags) {
    if (flag.label.empty()) continue;
    const std::vector<std::string> choices = label_choices(flag.label);
    if (!choices.empty())
      lines += fmt::format("        {}) words=\"{}\"; kind=words ;;\n", pattern(flag), fmt::join(choices, " "));
    else if (label_is_path(flag.label))
      lines += fmt::format("        {}) kind=files ;;\n", pattern(flag));
    else
      lines += fmt::format("        {}) kind=none ;;\n", pattern(flag));
  }
  return lines;
}

// Text between single quotes of zsh, within an argument's specification of _arguments.
std::string zsh_text(std::string_view text) {
  std::string quoted;
  for (const char c : text) {
    if (c == '\'')
      quoted += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      quoted += fmt::format("\\{}", c);
    else
      quoted += c;
  }
  return quoted;
}

std::string zsh_argument(const FlagRow& flag, const std::string& name) {
  std::string argument = fmt::format("'*{}[{}]", name, zsh_text(flag.description));
  if (!flag.label.empty()) {
    const std::vector<std::string> choices = label_choices(flag.label);
    argument += fmt::format(":{}:", zsh_text(flag.label));
    if (!choices.empty())
      argument += fmt::format("({})", fmt::join(choices, " "));
    else if (label_is_path(flag.label))
      argument += "_files";
  }
  return argument + "'";
}

} // namespace

std::string bash_completion(std::span<const CommandTable> commands) {
  std::string text =
      "# bash completion of kindling, written by 'kindling completion bash'.\n_kindling() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} words= kind=files\n"
      "  local command=${COMP_WORDS[1]}\n  if [ \"$COMP_CWORD\" -eq 1 ]; then\n";
  text += fmt::format("    COMPREPLY=($(compgen -W \"{} completion manual --help --version\" -- \"$current\"))\n"
                      "    return\n  fi\n",
                      fmt::join(first_words(commands), " "));
  for (const std::string& first : first_words(commands))
    if (const std::vector<std::string> seconds = second_words(commands, first); !seconds.empty())
      text += fmt::format(
          "  if [ \"$command\" = {} ]; then\n    if [ \"$COMP_CWORD\" -eq 2 ]; then\n      COMPREPLY=($(compgen "
          "-W \"{}\" -- \"$current\"))\n      return\n    fi\n    command=\"{} ${{COMP_WORDS[2]}}\"\n  fi\n",
          first, fmt::join(seconds, " "), first);
  text += "  case \"$command\" in\n    completion) words=\"bash zsh\"; kind=words ;;\n";
  for (const CommandTable& command : commands) {
    text += fmt::format(
        "    '{}')\n      case \"$previous\" in\n{}        *)\n          if [[ $current == -* ]]; then\n"
        "            words=\"{}\"\n            kind=words\n          fi\n          ;;\n      esac\n      ;;\n",
        command.name, bash_values(command), flag_names(command));
  }
  text += "  esac\n  case $kind in\n    words) COMPREPLY=($(compgen -W \"$words\" -- \"$current\")) ;;\n"
          "    files) compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -f -- \"$current\")) ;;\n"
          "    none) COMPREPLY=() ;;\n  esac\n}\ncomplete -F _kindling kindling\n";
  return text;
}

std::string zsh_completion(std::span<const CommandTable> commands) {
  std::string text =
      "#compdef kindling\n# zsh completion of kindling, written by 'kindling completion zsh'.\n_kindling() {\n"
      "  local command=$words[2]\n  if (( CURRENT == 2 )); then\n";
  text += fmt::format("    compadd {} completion manual --help --version\n    return\n  fi\n",
                      fmt::join(first_words(commands), " "));
  for (const std::string& first : first_words(commands))
    if (const std::vector<std::string> seconds = second_words(commands, first); !seconds.empty())
      text += fmt::format(
          "  if [[ $command == {} ]]; then\n    if (( CURRENT == 3 )); then\n      compadd {}\n      return\n    "
          "fi\n    command=\"{} $words[3]\"\n    shift words; (( CURRENT-- ))\n  fi\n",
          first, fmt::join(seconds, " "), first);
  text += "  shift words; (( CURRENT-- ))\n  case $command in\n    completion) compadd bash zsh ;;\n";
  for (const CommandTable& command : commands) {
    text += fmt::format("    '{}')\n      _arguments -s", command.name);
    for (const FlagRow& flag : command.flags) {
      if (!flag.short_name.empty()) text += " \\\n        " + zsh_argument(flag, flag.short_name);
      text += " \\\n        " + zsh_argument(flag, flag.long_name);
    }
    text += " \\\n        '*:file:_files'\n      ;;\n";
  }
  return text + "  esac\n}\n_kindling \"$@\"\n";
}

} // namespace kindling::app
