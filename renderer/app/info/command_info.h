// `kindling info` prints the contents of a scene or an accumulation file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"

namespace kindling::app {

// Returns the exit code.
[[nodiscard]] Result<int> run_info(const InfoOptions& options, Console& console);

} // namespace kindling::app
