// Reads /proc/stat and clocks, and judges what they show.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/measure/machine_watch.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>

namespace kindling::app {

namespace {

constexpr double kQuietOtherCores = 0.2, kQuietSteal = 0.01, kShortest_s = 1.0;

double processor_time_s(int who) {
  rusage usage{};
  if (getrusage(who, &usage) != 0) return 0.0;
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

} // namespace

MachineReading read_machine() {
  MachineReading reading;
  reading.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  reading.own_s = processor_time_s(RUSAGE_SELF) + processor_time_s(RUSAGE_CHILDREN);
  // proc(5): "cpu user nice system idle iowait irq softirq steal guest guest_nice", guests being
  // part of user and nice.
  std::ifstream stat("/proc/stat");
  std::string name;
  std::array<double, 8> ticks{};
  stat >> name;
  for (double& count : ticks) stat >> count;
  const auto ticks_per_s = static_cast<double>(sysconf(_SC_CLK_TCK));
  if (!stat || name != "cpu" || ticks_per_s <= 0.0) return reading;
  double all = 0.0;
  for (const double count : ticks) all += count;
  reading.busy_s = (ticks[0] + ticks[1] + ticks[2]) / ticks_per_s;
  reading.steal_s = ticks[7] / ticks_per_s;
  reading.all_s = all / ticks_per_s;
  return reading;
}

MachineState compare_readings(const MachineReading& begin, const MachineReading& end) {
  MachineState state;
  const double wall_s = end.wall_s - begin.wall_s;
  if (wall_s < kShortest_s) return state;
  if (begin.busy_s && end.busy_s)
    state.other_cores = std::max(0.0, (*end.busy_s - *begin.busy_s - (end.own_s - begin.own_s)) / wall_s);
  if (begin.steal_s && end.steal_s && begin.all_s && end.all_s && *end.all_s > *begin.all_s)
    state.steal_share = std::clamp((*end.steal_s - *begin.steal_s) / (*end.all_s - *begin.all_s), 0.0, 1.0);
  return state;
}

std::vector<std::string> describe_disturbances(const MachineState& state) {
  std::vector<std::string> sentences;
  if (state.other_cores.value_or(0.0) >= kQuietOtherCores)
    sentences.push_back(fmt::format("Other processes kept {:.1f} processors busy.", *state.other_cores));
  if (state.steal_share.value_or(0.0) >= kQuietSteal)
    sentences.push_back(fmt::format("The host of this virtual machine took {:.1f} % of its processor time (steal).",
                                    *state.steal_share * 100.0));
  return sentences;
}

} // namespace kindling::app
