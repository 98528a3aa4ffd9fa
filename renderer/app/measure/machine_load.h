// Detects measurements on a busy machine by the time that threads waited for a processor.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/stopwatch.h"

#include <string>

namespace kindling::app {

// Waiting shares up to this one are those of a quiet machine.
inline constexpr double kQuietWaitingShare = 0.02;

// The share of the threads' time, in [0, 1], in which they had work but no processor: another
// process had it, or pages were read. `idle_s`: seconds without work, summed over the threads. 0
// for no time.
[[nodiscard]] double waiting_share(const WorkTime& time, int threads = 1, double idle_s = 0.0);

// One sentence for reports that quote the measurements; empty for a quiet machine.
[[nodiscard]] std::string disturbance_warning(double waiting_share);

} // namespace kindling::app
