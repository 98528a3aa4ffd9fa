// Waiting time as a share, and the warning about it that all reports print.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_load.h"

#include <fmt/format.h>

#include <algorithm>

namespace kindling::app {

double waiting_share(const WorkTime& time, int threads, double idle_s) {
  const double threads_s = time.wall_s * threads;
  return threads_s > 0.0 ? std::max(0.0, threads_s - time.cpu_s - idle_s) / threads_s : 0.0;
}

std::string disturbance_warning(double waiting_share) {
  if (waiting_share < kQuietWaitingShare) return {};
  return fmt::format("The machine was not quiet: threads with work waited for a processor up to {:.1f} % of the time; "
                     "do not quote these figures.",
                     waiting_share * 100.0);
}

} // namespace kindling::app
