// The text of --version; version(), compiler() and program_identity() for the command line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/program_identity.h"

#include <string>

namespace kindling::app {

// Returns several lines (version, sources, compiler, accelerators, libraries) that end with '\n'.
[[nodiscard]] std::string version_text();

} // namespace kindling::app
