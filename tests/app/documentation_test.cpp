// The manual page and the shell completions hold every flag of every command.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/completion.h"
#include "renderer/app/flags/manual_page.h"
#include "renderer/app/flags/parse_command_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <regex>

#include <unistd.h>

namespace kindling::app {
namespace {

std::string help_of(const std::string& command) {
  std::vector<std::string> words;
  for (size_t begin = 0; begin < command.size();) {
    const size_t end = std::min(command.find(' ', begin), command.size());
    words.push_back(command.substr(begin, end - begin));
    begin = end + 1;
  }
  words.emplace_back("--help");
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  const Result<CommandLine> line = parse_command_line(arguments);
  EXPECT_TRUE(line.ok()) << line.error().message;
  return std::get<PrintText>(line.value().command).text;
}

const CommandTable& table_of(const std::vector<CommandTable>& tables, const std::string& name) {
  return *std::find_if(tables.begin(), tables.end(), [&](const CommandTable& table) { return table.name == name; });
}

// What bash would offer behind these words, one a line.
std::string complete(const std::string& words, int current) {
  const std::string file = testing::TempDir() + "kindling_completion_" + std::to_string(getpid());
  std::ofstream(file) << bash_completion(command_tables());
  const std::string command = "bash -c 'source " + file + "; COMP_WORDS=(" + words +
                              "); COMP_CWORD=" + std::to_string(current) +
                              "; _kindling 2>/dev/null; printf \"%s\\n\" \"${COMPREPLY[@]}\"'";
  std::string output;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  for (std::array<char, 256> line{}; std::fgets(line.data(), line.size(), pipe.get()) != nullptr;)
    output += line.data();
  std::remove(file.c_str());
  return output;
}

TEST(Documentation, TablesHoldTheFlagsOfTheHelp) {
  for (const CommandTable& table : command_tables()) {
    if (table.name.starts_with("farm ") && table.name != "farm submit") continue; // no flags of their own
    SCOPED_TRACE(table.name);
    const std::string help = help_of(table.name);
    const std::regex flag("(?:^|\\n) {1,4}(?:-\\w,)?(--[a-z][a-z0-9-]*)");
    size_t count = 0;
    for (std::sregex_iterator i(help.begin(), help.end(), flag), end; i != end; ++i) {
      const std::string name = (*i)[1];
      if (name == "--help") continue;
      ++count;
      EXPECT_TRUE(std::any_of(table.flags.begin(), table.flags.end(), [&](const FlagRow& row) {
        return row.long_name == name;
      })) << name;
    }
    EXPECT_EQ(table.flags.size(), count);
    EXPECT_GT(count, 1U);
  }
}

TEST(Documentation, RowsDistinguishValuesFromSwitches) {
  const std::vector<CommandTable> tables = command_tables();
  const CommandTable render = table_of(tables, "render");
  const auto row = [&](const std::string& name) {
    return *std::find_if(render.flags.begin(), render.flags.end(),
                         [&](const FlagRow& flag) { return flag.long_name == name; });
  };
  EXPECT_EQ(row("--output").short_name, "-o");
  EXPECT_EQ(row("--output").label, "FILE");
  EXPECT_EQ(row("--exr-float").label, "");
  EXPECT_EQ(row("--outliers").label, "keep|trim");
  EXPECT_EQ(row("--spp").description.find('\n'), std::string::npos);
}

TEST(Documentation, ManualPageHasEveryFlagAndEscapesText) {
  const std::vector<CommandTable> tables = command_tables();
  const std::string page = manual_page(tables, "1.2.3");
  EXPECT_TRUE(page.starts_with(".TH KINDLING 1 \"\" \"kindling 1.2.3\""));
  for (const CommandTable& table : tables)
    for (const FlagRow& flag : table.flags)
      EXPECT_NE(page.find(std::regex_replace(flag.long_name, std::regex("-"), "\\-")), std::string::npos)
          << flag.long_name;
  const CommandTable odd{"odd", "X", ".TH is no request\\here", {}};
  EXPECT_NE(manual_page(std::span(&odd, 1), "1").find("\n\\&.TH is no request\\ehere\n"), std::string::npos);
}

TEST(Documentation, LabelsGiveChoicesAndPaths) {
  EXPECT_EQ(label_choices("keep|trim"), (std::vector<std::string>{"keep", "trim"}));
  EXPECT_EQ(label_choices("env|sampled|R,G,B"), (std::vector<std::string>{"env", "sampled"}));
  EXPECT_TRUE(label_choices("NAME").empty());
  EXPECT_TRUE(label_is_path("FILE"));
  EXPECT_FALSE(label_is_path("N"));
}

TEST(Documentation, BashCompletesCommandsFlagsAndWords) {
  EXPECT_EQ(complete("kindling re", 1), "render\nresume\nrelight\n");
  EXPECT_EQ(complete("kindling render --outlie", 2), "--outliers\n");
  EXPECT_EQ(complete("kindling render --outliers k", 3), "keep\n");
  EXPECT_EQ(complete("kindling render --spp 1", 3), "\n");
  EXPECT_EQ(complete("kindling farm su", 2), "submit\n");
  EXPECT_EQ(complete("kindling farm submit --retr", 3), "--retries\n");
  EXPECT_EQ(complete("kindling completion z", 2), "zsh\n");
}

// Braces and quotes that do not match would show here; zsh itself is not needed.
TEST(Documentation, ZshCompletionHasEveryCommandAndBalancedQuotes) {
  const std::vector<CommandTable> tables = command_tables();
  const std::string text = zsh_completion(tables);
  EXPECT_TRUE(text.starts_with("#compdef kindling\n"));
  for (const CommandTable& table : tables) EXPECT_NE(text.find("    '" + table.name + "')\n"), std::string::npos);
  const std::string plain = std::regex_replace(text, std::regex("'\\\\''"), "");
  EXPECT_EQ(std::count(plain.begin(), plain.end(), '\'') % 2, 0);
}

} // namespace
} // namespace kindling::app
