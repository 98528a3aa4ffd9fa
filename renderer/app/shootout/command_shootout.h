// `kindling shootout` races accelerators on the rays of scenes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"

#include <string>

namespace kindling::app {

// Returns the exit code. `command_line` is stored in the reports.
[[nodiscard]] Result<int> run_shootout(const ShootoutOptions& options, const std::string& command_line,
                                       Console& console);

} // namespace kindling::app
