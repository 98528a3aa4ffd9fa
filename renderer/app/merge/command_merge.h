// `kindling merge` adds up accumulation files to one file or to images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"

#include <string>

namespace kindling::app {

// Returns the exit code: kExitIncomplete if parts are missing without --allow-missing.
[[nodiscard]] Result<int> run_merge(const MergeOptions& options, const std::string& command_line, Console& console);

} // namespace kindling::app
