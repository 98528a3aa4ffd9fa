// What became of the tasks of a farm so far, one small file each: written by whoever works on the task, read by everybody.
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

// Seconds since 1970, as records have them.
[[nodiscard]] double now_s();
// False as well where that cannot be known.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

enum class AttemptOutcome {
  running,     // or lost without a word; the next attempt, or the engine, tells
  done,        // the part is there
  interrupted, // asked to stop; went as far as its checkpoint
  failed,      // ended with exit code 1 or 4: another machine may do better
  crashed,     // ended by a signal that nobody meant: a crash, or out of memory
  refused,     // exit code 2 or 3: no machine can do better
  lost,        // its machine went away
  out_of_time, // the engine said so ahead; went as far as its checkpoint
};
[[nodiscard]] std::string_view outcome_name(AttemptOutcome outcome);

// Times are seconds since 1970 by the clock of the machine that worked.
struct FarmAttempt {
  std::string host;
  double start_s = 0.0;
  double end_s = 0.0;        // 0 while running
  double seen_s = 0.0;       // when `progress` was written
  double progress = 0.0;     // of the render, in [0, 1]
  bool resumed = false;      // from the checkpoint of an earlier attempt
  double saved_before = 0.0; // of the part's samples, the share that was in the checkpoint when it began, in [0, 1]
  double saved = 0.0;        // when it ended
  AttemptOutcome outcome = AttemptOutcome::running;
  int exit_code = 0;
  int signal = 0;
  std::string message; // the program's error line
  std::string log;     // relative to the farm's folder
};

struct TaskRecord {
  std::vector<FarmAttempt> attempts;
  std::string poisoned; // why it is not tried any more; empty: it may be

  [[nodiscard]] int count(AttemptOutcome outcome) const;
};

// The scene, or the flags, that no machine can render.
struct FarmRefusal {
  int exit_code = 0; // 2 or 3
  int task = 0;      // the first to find out
  std::string message;
};

// Of one frame.
struct MergeRecord {
  double end_s = 0.0;
  int exit_code = 0;   // of `kindling merge`; 0: the images are there
  std::string message; // its error line
};

// A machine that went away is not the part's fault, but a part that takes its machines along must end some time.
inline constexpr int kMaxLostAttempts = 5;
// A part that runs out of time goes on as long as it comes nearer to its end; not where so many attempts in a row have saved nothing more.
inline constexpr int kMaxFruitlessAttempts = 2;

// What to do after the last attempt of the record, which has ended.
enum class NextStep {
  finished,
  give_way, // whoever interrupted us says what happens
  go_on,    // by another process that has its own time
  retry,
  poison,
  refuse
};
struct Verdict {
  NextStep step = NextStep::finished;
  std::string reason; // of poison
};
[[nodiscard]] Verdict judge(const TaskRecord& record, int retries);
// How a render ended: exit code, or signal if not 0; `asked_by`: the signal that had us ask it to stop, or 0.
[[nodiscard]] AttemptOutcome outcome_of(int exit_code, int signal, int asked_by);

// A record that is not there is an empty one. Fail (input_output).
[[nodiscard]] Result<TaskRecord> read_task_record(const std::filesystem::path& path);
[[nodiscard]] Result<void> write_task_record(const std::filesystem::path& path, const TaskRecord& record);
[[nodiscard]] Result<std::optional<MergeRecord>> read_merge_record(const std::filesystem::path& path);
[[nodiscard]] Result<void> write_merge_record(const std::filesystem::path& path, const MergeRecord& record);
[[nodiscard]] Result<std::optional<FarmRefusal>> read_refusal(const std::filesystem::path& path);
[[nodiscard]] Result<void> write_refusal(const std::filesystem::path& path, const FarmRefusal& refusal);

} // namespace kindling
