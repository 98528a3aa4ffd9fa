// The state of a farm as people and as programs read it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/distributed/farm_status.h"

#include <string>

namespace kindling::app {

// A line for each frame, then what runs, what was given up with its reason and log, and what is missing.
[[nodiscard]] std::string format_farm_status(const FarmPlan& plan, const FarmStatus& status);
[[nodiscard]] std::string format_farm_json(const FarmPlan& plan, const FarmStatus& status);
// 0: all merged; the refusal's code (2 or 3); 5: parts are poisoned or missing, or a frame could not be merged; 6: it goes on.
[[nodiscard]] int farm_exit_code(const FarmStatus& status);

} // namespace kindling::app
