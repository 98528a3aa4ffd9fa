// Parses a `kindling render` command line from its flags into options or the error message.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/parse_command_line.h"
#include "renderer/app/options/options.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace kindling::app {

inline Result<CommandLine> parse(std::vector<const char*> flags) {
  std::vector<const char*> arguments{"render", "folder/a.glb"};
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  return parse_command_line(arguments);
}
inline RenderOptions options_of(std::vector<const char*> flags) {
  const Result<CommandLine> line = parse(std::move(flags));
  EXPECT_TRUE(line.ok()) << line.error().message;
  return line.ok() ? std::get<RenderOptions>(line.value().command) : RenderOptions();
}
inline std::string refusal(std::vector<const char*> flags) {
  const Result<CommandLine> line = parse(std::move(flags));
  EXPECT_FALSE(line.ok());
  return line.ok() ? "" : line.error().message;
}

} // namespace kindling::app
