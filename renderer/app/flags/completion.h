// Completion scripts for shells, written from the table of flags.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/flags/flag_table.h"

#include <span>
#include <string>

namespace kindling::app {

// To be sourced by bash, or to be installed as bash-completion/completions/kindling.
[[nodiscard]] std::string bash_completion(std::span<const CommandTable> commands);
// To be installed as _kindling in a folder of zsh's $fpath.
[[nodiscard]] std::string zsh_completion(std::span<const CommandTable> commands);

} // namespace kindling::app
