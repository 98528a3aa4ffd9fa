// Signs that a machine was not quiet while it measured: work of others, steal.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// Clocks, in seconds from any begin; what the operating system does not give is unset.
struct MachineReading {
  double wall_s = 0.0;
  double own_s = 0.0;            // processor time of this process and of its children that ended
  std::optional<double> busy_s;  // processor time of all processes, over all cores
  std::optional<double> steal_s; // time that the host of a virtual machine took, over all cores
  std::optional<double> all_s;   // time of all cores, idle time included
};
// Returns those of this machine, now.
[[nodiscard]] MachineReading read_machine();

// Between two readings.
struct MachineState {
  std::optional<double> other_cores; // processors that other processes kept busy, on average
  std::optional<double> steal_share; // [0, 1] of the time of all cores
};
// Unset for less than a second, because the operating system counts in hundredths.
[[nodiscard]] MachineState compare_readings(const MachineReading& begin, const MachineReading& end);

// One sentence for each sign: other processes used a fifth of a core or more, steal of a hundredth
// or more.
[[nodiscard]] std::vector<std::string> describe_disturbances(const MachineState& state);

} // namespace kindling::app
