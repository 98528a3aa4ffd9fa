// `kindling denoise`: denoises finished images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"

#include <string>

namespace kindling::app {

// Returns the exit code. A .kacc file is read as by run_merge(), with --allow-missing.
[[nodiscard]] Result<int> run_denoise(const DenoiseOptions& options, const std::string& command_line, Console& console);

} // namespace kindling::app
