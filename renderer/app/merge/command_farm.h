// `kindling farm`: frames in parts on many machines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/farm_options.h"
#include "renderer/app/terminal/console.h"

namespace kindling::app {

// The exit code.
[[nodiscard]] Result<int> run_farm(const FarmOptions& options, Console& console);

} // namespace kindling::app
