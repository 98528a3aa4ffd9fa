// `kindling scaling` measures thread scaling, from loading to the image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"

#include <string>

namespace kindling::app {

// Returns the exit code; 1 if images differ that must be equal. `command_line` is stored in the
// reports.
[[nodiscard]] Result<int> run_scaling(const ScalingOptions& options, const std::string& command_line, Console& console);

} // namespace kindling::app
