// `kindling scaling`: what more threads bring, from loading to the image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"

#include <string>

namespace kindling::app {

// The exit code; 1 if images differ that must not. `command_line` goes into the reports.
[[nodiscard]] Result<int> run_scaling(const ScalingOptions& options, const std::string& command_line, Console& console);

} // namespace kindling::app
