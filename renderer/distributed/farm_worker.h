// Worker for one task of a farm: runs, watches, records and retries its render; merging of frames.
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

// Receives each line for the log, from the worker or from its render.
using FarmLog = std::function<void(std::string_view)>;

// Returns the command that renders a task. It resumes from the task's checkpoint if there is one.
// `threads`: 0 for all.
[[nodiscard]] std::vector<std::string> render_command(const FarmPlan& plan, const FarmTask& task, int threads);
// Returns the command that merges a frame.
[[nodiscard]] std::vector<std::string> merge_command(const FarmPlan& plan, int frame_index);

// Works on a task until it is complete, given up, or left to the engine. Returns an exit code: 0 if
// the part is complete, 128 + signal if interrupted, 2 or 3 if scene or flags were refused (by this
// task or another), else that of the last attempt. Fails (input_output) if the records cannot be
// written.
[[nodiscard]] Result<int> work_on_task(const FarmPlan& plan, int number, FarmEngine& engine, const FarmLog& log);

struct MergeReport {
  int merged = 0;               // frames merged now
  int already = 0;              // frames merged before
  std::vector<std::string> bad; // a line for each poisoned or missing part and each frame that could not be merged
  int exit_code = 0;            // of the last failed merge: 1, 2, 4, or 128 + signal; missing parts leave it 0
};
// Merges all frames whose parts are complete and that are not merged yet.
[[nodiscard]] Result<MergeReport> merge_frames(const FarmPlan& plan, const FarmLog& log);

} // namespace kindling
