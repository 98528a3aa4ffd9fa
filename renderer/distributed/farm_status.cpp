// Combines a farm's records and its engine's queue into a status.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_status.h"

#include <algorithm>

namespace kindling {

namespace {

TaskStatus task_status(const FarmPlan& plan, const FarmTask& task, const std::optional<FarmQueue>& queue,
                       const std::optional<FarmRefusal>& refusal) {
  TaskStatus status;
  status.task = task;
  // An unreadable record is ignored: the part's file is what counts.
  if (Result<TaskRecord> record = read_task_record(plan.task_record_file(task)); record.ok())
    status.record = std::move(record).value();
  const FarmAttempt* last = status.record.attempts.empty() ? nullptr : &status.record.attempts.back();
  if (last != nullptr) {
    status.host = last->host;
    status.progress = last->progress;
  }
  const auto queued = queue ? queue->tasks.find(task.number) : decltype(queue->tasks.find(0)){};
  const bool known = queue && queued != queue->tasks.end();
  std::error_code error;
  if (std::filesystem::exists(plan.part_file(task), error)) {
    status.state = TaskState::done;
    status.progress = 1.0;
  } else if (!status.record.poisoned.empty()) {
    status.state = TaskState::poisoned;
    status.reason = status.record.poisoned;
  } else if (refusal) {
    status.state = TaskState::refused;
    status.reason = refusal->message;
  } else if (known) {
    status.state = queued->second.state == QueueState::running ? TaskState::running : TaskState::waiting;
    if (status.state == TaskState::running) status.host = queued->second.host;
    if (status.state == TaskState::waiting) status.reason = queued->second.reason;
  } else if (!queue) {
    // Without a queue, the record is the only source.
    status.state =
        last != nullptr && last->outcome == AttemptOutcome::running ? TaskState::running : TaskState::waiting;
  } else if (last != nullptr) {
    status.reason = last->outcome == AttemptOutcome::running ? "ended without a report on " + last->host
                                                             : std::string(outcome_name(last->outcome));
    if (!last->message.empty()) status.reason += ": " + last->message;
  } else {
    status.reason = "not in the queue";
  }
  return status;
}

} // namespace

std::string_view task_state_name(TaskState state) {
  switch (state) {
  case TaskState::done: return "done";
  case TaskState::running: return "running";
  case TaskState::waiting: return "waiting";
  case TaskState::poisoned: return "poisoned";
  case TaskState::refused: return "refused";
  case TaskState::missing: return "missing";
  }
  return "?";
}

int FrameStatus::count(TaskState state) const {
  return static_cast<int>(
      std::count_if(tasks.begin(), tasks.end(), [&](const TaskStatus& task) { return task.state == state; }));
}

int FrameStatus::retried() const {
  int sum = 0;
  for (const TaskStatus& task : tasks) sum += std::max(0, static_cast<int>(task.record.attempts.size()) - 1);
  return sum;
}

int FarmStatus::count(TaskState state) const {
  int sum = 0;
  for (const FrameStatus& frame : frames) sum += frame.count(state);
  return sum;
}

bool FarmStatus::all_merged() const {
  return std::all_of(frames.begin(), frames.end(), [](const FrameStatus& frame) { return frame.merged(); });
}

bool FarmStatus::in_progress() const {
  return merge_waits || count(TaskState::running) > 0 || count(TaskState::waiting) > 0;
}

Result<FarmStatus> farm_status(const FarmPlan& plan, const std::optional<FarmQueue>& queue) {
  FarmStatus status;
  Result<std::optional<FarmRefusal>> refusal = read_refusal(plan.refusal_file());
  if (!refusal.ok()) return refusal.error();
  status.refusal = std::move(refusal).value();
  status.merge_waits = queue && queue->merge;
  for (int index = 0; index < plan.frame_count(); ++index) {
    FrameStatus& frame = status.frames.emplace_back();
    frame.index = index;
    frame.frame = plan.frame(index);
    for (int part = 0; part < plan.parts; ++part)
      frame.tasks.push_back(task_status(plan, plan.task(index * plan.parts + part), queue, status.refusal));
    if (Result<std::optional<MergeRecord>> merge = read_merge_record(plan.frame_record_file(index)); merge.ok())
      frame.merge = std::move(merge).value();
  }
  return status;
}

} // namespace kindling
