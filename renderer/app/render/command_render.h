// `kindling render`: from options to images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"

#include <string>

namespace kindling::app {

// The exit code. `command_line` goes into the images' metadata.
[[nodiscard]] Result<int> run_render(const RenderOptions& options, const std::string& command_line, Console& console);

} // namespace kindling::app
