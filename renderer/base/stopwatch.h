// How long work takes: on the wall, and of the processors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

namespace kindling {

// Seconds. cpu_s is that of all threads of the process: over wall_s, on how many cores the work ran in the mean.
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

// Runs from its construction on.
class Stopwatch {
 public:
  [[nodiscard]] WorkTime elapsed() const {
    return {seconds(CLOCK_MONOTONIC) - start_.wall_s, seconds(CLOCK_PROCESS_CPUTIME_ID) - start_.cpu_s};
  }
  // elapsed(), and from now on.
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
