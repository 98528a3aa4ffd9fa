// A device of a race beside the accelerators that ran on the processor.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/shootout/shootout_report.h"

#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// A kind of rays that has any.
struct DeviceComparisonLine {
  std::string rays;
  Summary launch_s, with_copies_s;           // of all rays
  double mega_rays = 0.0;                    // their number in millions
  std::vector<std::optional<double>> ratios; // by rival, of the launch to its fastest call; 0: below the clock
};

struct DeviceComparison {
  std::string contender; // "kdtree on gpu"
  std::string device;    // its name
  uint64_t tree_bytes = 0;
  OracleCheck check;
  std::vector<std::string> rivals; // what ran on the processor, on one thread
  std::vector<DeviceComparisonLine> lines;
  std::vector<std::optional<double>> means; // by rival, geometric over the lines
};

// The device of the race; none without one, or if it is out of the race.
[[nodiscard]] std::optional<DeviceComparison> compare_device(const SceneResult& scene);

// One row for each line, then one of the means; every row has a cell for each heading.
struct DeviceTable {
  std::vector<std::string> heading;
  std::vector<std::vector<std::string>> rows;
};
[[nodiscard]] DeviceTable tabulate(const DeviceComparison& comparison);
// "1.2 MiB of its memory; 0 of 300 answers differ from those of the tree on the processor".
[[nodiscard]] std::string describe_check(const DeviceComparison& comparison);
// The table for a terminal; empty without a device. Ends with '\n'.
[[nodiscard]] std::string format_device_table(const SceneResult& scene);

} // namespace kindling::app
