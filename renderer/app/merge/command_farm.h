// `kindling farm` renders frames in parts on the machines of a cluster.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/farm_options.h"
#include "renderer/app/terminal/console.h"

namespace kindling::app {

// Runs one action; returns the exit code.
[[nodiscard]] Result<int> run_farm(const FarmOptions& options, Console& console);

} // namespace kindling::app
