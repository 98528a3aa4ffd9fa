// Wall time since a moment, for reports.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace kindling::app {

using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

} // namespace kindling::app
