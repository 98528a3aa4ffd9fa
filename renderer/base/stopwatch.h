// Stopwatch for wall-clock time and for the processor time of all threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

namespace kindling {

// Durations in seconds. cpu_s sums over all threads of the process; cpu_s / wall_s is the mean
// number of busy cores.
struct WorkTime {
  double wall_s = 0.0;
  double cpu_s = 0.0;

  WorkTime& operator+=(const WorkTime& other) {
    wall_s += other.wall_s;
    cpu_s += other.cpu_s;
    return *this;
  }
};
[[nodiscard]] inline WorkTime operator-(const WorkTime& a, const WorkTime& b) {
  return {a.wall_s - b.wall_s, a.cpu_s - b.cpu_s};
}

// A stopwatch that starts when it is constructed.
class Stopwatch {
 public:
  [[nodiscard]] WorkTime elapsed() const {
    return {seconds(CLOCK_MONOTONIC) - start_.wall_s, seconds(CLOCK_PROCESS_CPUTIME_ID) - start_.cpu_s};
  }
  // Returns elapsed() and restarts.
  WorkTime lap() {
    const WorkTime result = elapsed();
    start_ += result;
    return result;
  }

 private:
  static double seconds(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  WorkTime start_{seconds(CLOCK_MONOTONIC), seconds(CLOCK_PROCESS_CPUTIME_ID)};
};

} // namespace kindling
