// Status of a farm, from its records and its engine's queue.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/distributed/farm_engine.h"
#include "renderer/distributed/farm_plan.h"
#include "renderer/distributed/farm_records.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

enum class TaskState {
  done, // the part is complete
  running,
  waiting,  // in the engine's queue
  poisoned, // given up after too many failures
  refused,  // scene or flags are invalid
  missing,  // neither complete nor in the queue: cancelled, out of time, or never submitted
};
[[nodiscard]] std::string_view task_state_name(TaskState state);

struct TaskStatus {
  FarmTask task;
  TaskState state = TaskState::missing;
  TaskRecord record;
  std::string host;      // of the last attempt
  double progress = 0.0; // in [0, 1]
  std::string reason;    // for waiting, or for being poisoned, refused or missing
};

struct FrameStatus {
  int index = 0;
  std::optional<int> frame;
  std::vector<TaskStatus> tasks;
  std::optional<MergeRecord> merge;

  [[nodiscard]] int count(TaskState state) const;
  [[nodiscard]] int retried() const; // attempts after the first ones
  [[nodiscard]] bool merged() const { return merge && merge->exit_code == 0; }
};

struct FarmStatus {
  std::vector<FrameStatus> frames;
  std::optional<FarmRefusal> refusal;
  bool merge_waits = false; // the merge job is in the queue
  std::string queue_error;  // set if the engine could not be asked; then the status is from the records alone

  [[nodiscard]] int count(TaskState state) const;
  [[nodiscard]] bool all_merged() const;
  // True if tasks or the merge job are still running or waiting.
  [[nodiscard]] bool in_progress() const;
};

// Combines records and queue; `queue` is unset if the engine could not be asked. Fails
// (input_output).
[[nodiscard]] Result<FarmStatus> farm_status(const FarmPlan& plan, const std::optional<FarmQueue>& queue);

} // namespace kindling
