// `kindling info`: what is in a file, as tables or JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"

namespace kindling::app {

// The exit code.
[[nodiscard]] Result<int> run_info(const InfoOptions& options, Console& console);

} // namespace kindling::app
