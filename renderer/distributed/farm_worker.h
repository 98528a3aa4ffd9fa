// Working on one task of a farm: a render as a process of its own, watched, recorded, and tried again.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/distributed/farm_engine.h"
#include "renderer/distributed/farm_plan.h"
#include "renderer/distributed/farm_records.h"

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// A line for the log, of ours or of the program that works.
using FarmLog = std::function<void(std::string_view)>;

// The command that works on a task: it goes on from its checkpoint where there is one. `threads`: 0 for all.
[[nodiscard]] std::vector<std::string> render_command(const FarmPlan& plan, const FarmTask& task, int threads);
// The command that merges a frame.
[[nodiscard]] std::vector<std::string> merge_command(const FarmPlan& plan, int frame_index);

// The exit code: 0 where the part is there, 128 + signal where it was interrupted, 2 or 3 where scene or flags are refused (of this
// task or another), else that of the last attempt. Fails (input_output) where the records cannot be kept.
[[nodiscard]] Result<int> work_on_task(const FarmPlan& plan, int number, FarmEngine& engine, const FarmLog& log);

// Merges the frames whose parts are all there and that are not merged yet.
struct MergeReport {
  int merged = 0;  // now
  int already = 0; // before
  std::vector<std::string>
      bad;           // a line for each part that is poisoned or missing, and for each frame that could not be merged
  int exit_code = 0; // of the worst merge: 1, 2, 4, or 128 + signal; 0 if all went well, parts missing or not
};
[[nodiscard]] Result<MergeReport> merge_frames(const FarmPlan& plan, const FarmLog& log);

} // namespace kindling
