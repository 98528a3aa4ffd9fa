// Merges the frames of a farm, each in a process of its own.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_worker.h"
#include "renderer/distributed/program_lines.h"
#include "renderer/distributed/run_process.h"

#include <fmt/format.h>

namespace kindling {

namespace {

// Returns the reason why a part is missing, with its last log.
std::string describe_absence(const FarmPlan& plan, const FarmTask& task) {
  const Result<TaskRecord> record = read_task_record(plan.task_record_file(task));
  if (!record.ok()) return record.error().message;
  std::string text = record.value().poisoned.empty() ? "missing" : "poisoned: " + record.value().poisoned;
  if (!record.value().attempts.empty() && !record.value().attempts.back().log.empty())
    text += fmt::format(" ({})", (plan.folder / record.value().attempts.back().log).string());
  return text;
}

} // namespace

Result<MergeReport> merge_frames(const FarmPlan& plan, const FarmLog& log) {
  MergeReport report;
  SignalInbox signals;
  for (int index = 0; index < plan.frame_count() && signals.received() == 0; ++index) {
    const std::string frame = plan.frame(index) ? fmt::format("frame {}: ", *plan.frame(index)) : "";
    const Result<std::optional<MergeRecord>> before = read_merge_record(plan.frame_record_file(index));
    if (before.ok() && before.value() && before.value()->exit_code == 0) {
      ++report.already;
      continue;
    }
    const size_t bad = report.bad.size();
    for (int part = 1; part <= plan.parts; ++part) {
      const FarmTask task{index * plan.parts + part - 1, plan.frame(index), part};
      if (file_exists(plan.part_file(task))) continue;
      report.bad.push_back(fmt::format("{}part {}/{} {}", frame, part, plan.parts, describe_absence(plan, task)));
    }
    if (report.bad.size() > bad) continue;

    ProgramLines lines(log);
    const auto on_line = [&](std::string_view line) { (void)lines.take(line); };
    const Result<ProcessEnd> end = run_watched(merge_command(plan, index), plan.working_folder, signals, on_line);
    if (!end.ok()) return end.error();
    const int code = end.value().signal != 0 ? 128 + end.value().signal : end.value().exit_code;
    if (signals.received() != 0 && code != 0) break;
    if (Result<void> saved = write_merge_record(plan.frame_record_file(index), {now_s(), code, lines.error});
        !saved.ok())
      return saved.error();
    if (code == 0) {
      ++report.merged;
    } else {
      report.exit_code = code;
      report.bad.push_back(fmt::format("{}could not be merged: {}", frame,
                                       lines.error.empty() ? fmt::format("exit code {}", code) : lines.error));
    }
  }
  if (signals.received() != 0) report.exit_code = 128 + signals.received();
  return report;
}

} // namespace kindling
