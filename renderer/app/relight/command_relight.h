// `kindling relight`: mixes the light groups of a finished image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"

#include <string>

namespace kindling::app {

// Returns the exit code.
[[nodiscard]] Result<int> run_relight(const RelightOptions& options, const std::string& command_line, Console& console);

} // namespace kindling::app
