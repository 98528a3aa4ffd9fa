// Where a farm stands: its records, and what its engine still has.
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
  done,     // its part is there
  running,  // somewhere, now
  waiting,  // in the engine's queue
  poisoned, // failed too often
  refused,  // the scene or the flags are no good
  missing,  // neither there nor in the queue: cancelled, out of time, or never handed over
};
[[nodiscard]] std::string_view task_state_name(TaskState state);

struct TaskStatus {
  FarmTask task;
  TaskState state = TaskState::missing;
  TaskRecord record;
  std::string host;      // of the last attempt
  double progress = 0.0; // in [0, 1]
  std::string reason;    // why it waits, or will not be done
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
  std::string queue_error;  // the engine could not be asked; what runs is told by the records alone

  [[nodiscard]] int count(TaskState state) const;
  [[nodiscard]] bool all_merged() const;
  // Whether anything of it is still to come by itself.
  [[nodiscard]] bool goes_on() const;
};

// Unset `queue`: the engine could not be asked.
[[nodiscard]] Result<FarmStatus> farm_status(const FarmPlan& plan, const std::optional<FarmQueue>& queue);

} // namespace kindling
