// Writes repeated measurements as JSON.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/measure/measurement.h"

#include <nlohmann/json.hpp>

#include <vector>

namespace kindling::app {

// An object with median_s, min_s, max_s, spread_percent and times_s.
[[nodiscard]] inline nlohmann::ordered_json summary_json(const std::vector<double>& times_s) {
  const Summary summary = summarize(times_s);
  return {{"median_s", summary.median},
          {"min_s", summary.min},
          {"max_s", summary.max},
          {"spread_percent", summary.spread_percent()},
          {"times_s", times_s}};
}

} // namespace kindling::app
