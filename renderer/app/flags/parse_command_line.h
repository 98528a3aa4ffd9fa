// Parses the arguments of the program into a command and its options.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_table.h"
#include "renderer/app/options/farm_options.h"
#include "renderer/app/options/options.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/base/result.h"

#include <span>
#include <string>
#include <variant>
#include <vector>

namespace kindling::app {

// The text of --help or --version, for standard output.
struct PrintText {
  std::string text;
};

struct CommandLine {
  std::variant<PrintText, RenderOptions, ResumeOptions, InfoOptions, ShootoutOptions, ScalingOptions, MergeOptions,
               DenoiseOptions, RelightOptions, LiveOptions, FarmOptions>
      command;
  std::string text; // as typed, quoted for a shell: for metadata and replays
};

// `arguments` are those after the program's name. Fails (usage).
[[nodiscard]] Result<CommandLine> parse_command_line(std::span<const char* const> arguments);
// Every command with its flags, for the manual and the completions.
[[nodiscard]] std::vector<CommandTable> command_tables();
// The end of a usage error's message: " (try 'kindling render --help')".
[[nodiscard]] std::string help_hint(std::span<const char* const> arguments);

} // namespace kindling::app
