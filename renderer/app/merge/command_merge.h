// `kindling merge`: from accumulation files to one, and to images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/terminal/console.h"
#include "renderer/base/result.h"

#include <string>

namespace kindling::app {

// The exit code: kExitIncomplete if parts are missing and that is not allowed.
[[nodiscard]] Result<int> run_merge(const MergeOptions& options, const std::string& command_line, Console& console);

} // namespace kindling::app
