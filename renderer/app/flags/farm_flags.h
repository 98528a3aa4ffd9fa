// Parses the arguments of `kindling farm` into its options.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_table.h"
#include "renderer/app/options/farm_options.h"
#include "renderer/base/result.h"

#include <span>
#include <string>
#include <vector>

namespace kindling::app {

struct FarmCommandLine {
  FarmOptions options;
  std::string help; // if not empty, this text is printed instead
};
// `arguments` are those after "farm". Fails (usage).
[[nodiscard]] Result<FarmCommandLine> parse_farm_command(std::span<const char* const> arguments);
// "farm submit" and the other actions with their flags.
[[nodiscard]] std::vector<CommandTable> farm_tables();

} // namespace kindling::app
