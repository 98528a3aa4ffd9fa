// The clocks that measurements are taken with.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <ctime>

namespace kindling::app {

// wall: what a person waits. cpu: what the thread itself worked, which a busy machine disturbs less.
enum class ShootoutClock { wall, cpu };

// Seconds since some moment; differences count. cpu: of the calling thread.
[[nodiscard]] inline double clock_s(ShootoutClock clock) {
  timespec now{};
  clock_gettime(clock == ShootoutClock::cpu ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// CPU time of all threads of the process, or wall time: for builds on one thread, which a library may move to a thread of
// its own.
[[nodiscard]] inline double process_clock_s(ShootoutClock clock) {
  timespec now{};
  clock_gettime(clock == ShootoutClock::cpu ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

} // namespace kindling::app
