// The state of a farm as a table and as JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/distributed/farm_status.h"

#include <string>

namespace kindling::app {

// A line for each frame, then tables of running tasks, of poisoned ones with reason and log, and of
// missing ones.
[[nodiscard]] std::string format_farm_status(const FarmPlan& plan, const FarmStatus& status);
[[nodiscard]] std::string format_farm_json(const FarmPlan& plan, const FarmStatus& status);
// 0: all frames are merged; 2 or 3: refused by the renderer; 5: parts are poisoned or missing, or a
// merge failed; 6: in progress.
[[nodiscard]] int farm_exit_code(const FarmStatus& status);

} // namespace kindling::app
