// Reports on frames of an animation: skipped and rendered ones, and their times.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/output/report.h"

#include <cstddef>
#include <string>
#include <vector>

namespace kindling::app {

struct FramesReport {
  std::string command_line;
  size_t wanted = 0;
  std::vector<int> rendered; // completely
  std::vector<int> skipped;  // their files existed
  double load_s = 0.0;
  PhaseTimes phases;    // sums over the frames of this run
  double total_s = 0.0; // since the process was started
  int exit_code = 0;
  std::vector<std::string> statistics; // format_stats_json() of each frame of this run, if all go into one file
};

// Returns "1-3, 7, 9-11", in the order given.
[[nodiscard]] std::string format_frame_numbers(const std::vector<int>& numbers);
// Returns "frame 12 (3 of 10): 4.56 s: build 0.12 s, render 4.31 s, write 0.13 s"
[[nodiscard]] std::string format_frame_line(const RenderReport& report, size_t index, size_t count);
// Returns several lines without a final '\n'.
[[nodiscard]] std::string format_frames_summary(const FramesReport& report);
// The keys are described in renderer/app/README.md. `one_line`: the event that ends --progress
// json, which lacks the statistics of the frames.
[[nodiscard]] std::string format_frames_json(const FramesReport& report, bool one_line);

} // namespace kindling::app
