// Entry of `kindling render`.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"

#include <string>

namespace kindling::app {

// Returns the exit code. `command_line` is stored in the metadata of images.
[[nodiscard]] Result<int> run_render(const RenderOptions& options, const std::string& command_line, Console& console);

} // namespace kindling::app
