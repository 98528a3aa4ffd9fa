// The clocks of a shootout: wall time and CPU time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <ctime>
#include <string_view>

namespace kindling::app {

// wall: elapsed time. cpu: processor time of the thread, which other work on the machine disturbs
// less.
enum class ShootoutClock { wall, cpu };
// "wall", "cpu".
[[nodiscard]] constexpr std::string_view clock_name(ShootoutClock clock) {
  return clock == ShootoutClock::cpu ? "cpu" : "wall";
}

// Seconds since an arbitrary moment. ShootoutClock::cpu reads the CPU time of the calling thread.
[[nodiscard]] inline double clock_s(ShootoutClock clock) {
  timespec now{};
  clock_gettime(clock == ShootoutClock::cpu ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// The same with the CPU time of all threads of the process, for builds on one thread, which a
// library may run on a thread of its own.
[[nodiscard]] inline double process_clock_s(ShootoutClock clock) {
  timespec now{};
  clock_gettime(clock == ShootoutClock::cpu ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

} // namespace kindling::app
