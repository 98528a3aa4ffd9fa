// Records of a farm's tasks, one small JSON file each, and the decisions that follow from them.
//
// A record is written by the process that works on the task and read by all others.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/distributed/farm_plan.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Returns the time in seconds since 1970, the clock of records.
[[nodiscard]] double now_s();
// True if the file exists. False on errors, too.
[[nodiscard]] bool file_exists(const std::filesystem::path& path);

enum class AttemptOutcome {
  running,     // or lost; the next attempt or the engine's queue shows which
  done,        // the part is complete
  interrupted, // stopped on request, with a checkpoint
  failed,      // exit code 1 or 4: may succeed on another machine
  crashed,     // ended by an unintended signal: a crash, or out of memory
  refused,     // exit code 2 or 3: fails on every machine
  lost,        // with its machine
  out_of_time, // stopped by the engine's warning before its time limit, with a checkpoint
};
[[nodiscard]] std::string_view outcome_name(AttemptOutcome outcome);

// One attempt at a task. Times are seconds since 1970 by the clock of the machine that rendered.
struct FarmAttempt {
  std::string host;
  double start_s = 0.0;
  double end_s = 0.0;        // 0 while running
  double seen_s = 0.0;       // time of `progress`
  double progress = 0.0;     // of the render, in [0, 1]
  bool resumed = false;      // from the checkpoint of an earlier attempt
  double saved_before = 0.0; // fraction of the part's samples in the checkpoint at the start, in [0, 1]
  double saved = 0.0;        // the same at the end
  AttemptOutcome outcome = AttemptOutcome::running;
  int exit_code = 0;
  int signal = 0;
  std::string message; // the program's error line
  std::string log;     // relative to the farm's folder
};

struct TaskRecord {
  std::vector<FarmAttempt> attempts;
  std::string poisoned; // reason for giving the task up; empty if it may be tried

  [[nodiscard]] int count(AttemptOutcome outcome) const;
};

// A scene or flags that no machine can render.
struct FarmRefusal {
  int exit_code = 0; // 2 or 3
  int task = 0;      // number of the first refused task
  std::string message;
};

// The merge of one frame.
struct MergeRecord {
  double end_s = 0.0;
  int exit_code = 0;   // of `kindling merge`; 0: the images are written
  std::string message; // its error line
};

// Lost machines are no fault of the part, but a part that crashes its machines must be given up at
// some point.
inline constexpr int kMaxLostAttempts = 5;
// A part that runs out of time resumes as long as it makes progress; this many attempts in a row
// without any poison it.
inline constexpr int kMaxFruitlessAttempts = 2;

// The step after the last attempt of a record, which has ended.
enum class NextStep {
  finished,
  give_way,     // the sender of the interrupt decides about the task
  resume_later, // in another process with a time limit of its own
  retry,
  poison,
  refuse
};
struct Verdict {
  NextStep step = NextStep::finished;
  std::string reason; // for NextStep::poison
};
[[nodiscard]] Verdict judge(const TaskRecord& record, int retries);
// Classifies the end of a render by its exit code, or its signal if not 0. `asked_by` is the signal
// on which it was asked to stop, or 0.
[[nodiscard]] AttemptOutcome outcome_of(int exit_code, int signal, int asked_by);

// Read and write records. A missing file is an empty record. Fail (input_output).
[[nodiscard]] Result<TaskRecord> read_task_record(const std::filesystem::path& path);
[[nodiscard]] Result<void> write_task_record(const std::filesystem::path& path, const TaskRecord& record);
[[nodiscard]] Result<std::optional<MergeRecord>> read_merge_record(const std::filesystem::path& path);
[[nodiscard]] Result<void> write_merge_record(const std::filesystem::path& path, const MergeRecord& record);
[[nodiscard]] Result<std::optional<FarmRefusal>> read_refusal(const std::filesystem::path& path);
[[nodiscard]] Result<void> write_refusal(const std::filesystem::path& path, const FarmRefusal& refusal);

} // namespace kindling
