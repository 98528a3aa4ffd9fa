// Formats the state of a farm.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/merge/farm_report.h"

#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/text/text_format.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace kindling::app {

namespace {

std::string frame_name(const FrameStatus& frame) { return frame.frame ? std::to_string(*frame.frame) : "-"; }

std::string frame_state(const FrameStatus& frame) {
  if (frame.merged()) return "merged";
  if (frame.merge) return "merge failed";
  if (frame.count(TaskState::refused) > 0) return "refused";
  if (frame.count(TaskState::poisoned) > 0) return "poisoned";
  if (frame.count(TaskState::running) > 0) return "running";
  if (frame.count(TaskState::missing) > 0) return "missing";
  return frame.count(TaskState::waiting) > 0 ? "waiting" : "rendered";
}

std::string number_or_dash(int number) { return number == 0 ? "-" : std::to_string(number); }

// The mean progress of the parts, all with the same weight.
double progress_of(const FrameStatus& frame) {
  double sum = 0.0;
  for (const TaskStatus& task : frame.tasks) sum += task.progress;
  return frame.tasks.empty() ? 0.0 : sum / static_cast<double>(frame.tasks.size());
}

std::string log_of(const FarmPlan& plan, const TaskStatus& task) {
  if (task.record.attempts.empty() || task.record.attempts.back().log.empty()) return "-";
  return (plan.folder / task.record.attempts.back().log).string();
}

std::string list_tasks(const FarmPlan& plan, const FarmStatus& status, TaskState state) {
  const bool runs = state == TaskState::running;
  TextTable table(runs ? std::vector<TextTable::Column>{{"frame", true},
                                                        {"part", true},
                                                        {"host"},
                                                        {"progress", true},
                                                        {"attempt", true}}
                       : std::vector<TextTable::Column>{
                             {"frame", true}, {"part", true}, {"reason", false, true}, {"log", false, true}});
  for (const FrameStatus& frame : status.frames)
    for (const TaskStatus& task : frame.tasks) {
      if (task.state != state) continue;
      const std::string part = fmt::format("{}/{}", task.task.part, plan.parts);
      if (runs)
        table.add({frame_name(frame), part, task.host, fmt::format("{:.0f}%", 100.0 * task.progress),
                   std::to_string(task.record.attempts.size())});
      else
        table.add({frame_name(frame), part, task.reason, log_of(plan, task)});
    }
  if (table.empty()) return {};
  return fmt::format("\n{}\n{}", task_state_name(state), table.str());
}

nlohmann::ordered_json task_json(const FarmPlan& plan, const TaskStatus& task) {
  nlohmann::ordered_json json;
  json["task"] = task.task.number;
  json["part"] = task.task.part;
  json["state"] = task_state_name(task.state);
  json["progress"] = task.progress;
  json["host"] = task.host;
  json["reason"] = task.reason;
  json["log"] = task.record.attempts.empty() ? "" : log_of(plan, task);
  json["attempts"] = nlohmann::ordered_json::array();
  for (const FarmAttempt& attempt : task.record.attempts)
    json["attempts"].push_back({{"host", attempt.host},
                                {"start_s", attempt.start_s},
                                {"end_s", attempt.end_s},
                                {"outcome", outcome_name(attempt.outcome)},
                                {"resumed", attempt.resumed},
                                {"saved", attempt.saved},
                                {"exit_code", attempt.exit_code},
                                {"signal", attempt.signal},
                                {"message", attempt.message}});
  return json;
}

} // namespace

std::string format_farm_status(const FarmPlan& plan, const FarmStatus& status) {
  std::string text = fmt::format("{}: {} in {} part{}\n", printable(plan.folder.string()),
                                 printable(plan.scene.filename().string()), plan.parts, plan.parts == 1 ? "" : "s");
  TextTable table({{"frame", true},
                   {"state"},
                   {"progress", true},
                   {"done", true},
                   {"running", true},
                   {"waiting", true},
                   {"retried", true},
                   {"poisoned", true},
                   {"missing", true}});
  for (const FrameStatus& frame : status.frames)
    table.add({frame_name(frame), frame_state(frame), fmt::format("{:.0f}%", 100.0 * progress_of(frame)),
               fmt::format("{}/{}", frame.count(TaskState::done), plan.parts),
               number_or_dash(frame.count(TaskState::running)), number_or_dash(frame.count(TaskState::waiting)),
               number_or_dash(frame.retried()), number_or_dash(frame.count(TaskState::poisoned)),
               number_or_dash(frame.count(TaskState::missing))});
  text += table.str();
  for (const TaskState state : {TaskState::running, TaskState::poisoned, TaskState::missing})
    text += list_tasks(plan, status, state);
  for (const FrameStatus& frame : status.frames)
    if (frame.merge && !frame.merged())
      text += fmt::format("\nframe {} could not be merged: {}\n", frame_name(frame), printable(frame.merge->message));
  if (status.refusal)
    text += fmt::format("\nrefused by task {}, exit code {}: {}\n", status.refusal->task, status.refusal->exit_code,
                        printable(status.refusal->message));
  return text;
}

std::string format_farm_json(const FarmPlan& plan, const FarmStatus& status) {
  nlohmann::ordered_json json;
  json["folder"] = plan.folder.string();
  json["scene"] = plan.scene.string();
  json["parts"] = plan.parts;
  json["tasks"] = plan.task_count();
  for (const TaskState state : {TaskState::done, TaskState::running, TaskState::waiting, TaskState::poisoned,
                                TaskState::refused, TaskState::missing})
    json[std::string(task_state_name(state))] = status.count(state);
  json["goes_on"] = status.in_progress();
  json["exit_code"] = farm_exit_code(status);
  json["refusal"] = status.refusal ? nlohmann::ordered_json{{"exit_code", status.refusal->exit_code},
                                                            {"task", status.refusal->task},
                                                            {"message", status.refusal->message}}
                                   : nlohmann::ordered_json();
  json["frames"] = nlohmann::ordered_json::array();
  for (const FrameStatus& frame : status.frames) {
    nlohmann::ordered_json entry;
    entry["frame"] = frame.frame ? nlohmann::ordered_json(*frame.frame) : nlohmann::ordered_json();
    entry["state"] = frame_state(frame);
    entry["progress"] = progress_of(frame);
    entry["retried"] = frame.retried();
    entry["merged_s"] = frame.merged() ? nlohmann::ordered_json(frame.merge->end_s) : nlohmann::ordered_json();
    entry["outputs"] = nlohmann::ordered_json::array();
    for (const std::filesystem::path& output : plan.outputs_of(frame.index))
      entry["outputs"].push_back(output.string());
    entry["tasks"] = nlohmann::ordered_json::array();
    for (const TaskStatus& task : frame.tasks) entry["tasks"].push_back(task_json(plan, task));
    json["frames"].push_back(std::move(entry));
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

int farm_exit_code(const FarmStatus& status) {
  if (status.all_merged()) return kExitOk;
  if (status.refusal) return status.refusal->exit_code;
  if (status.count(TaskState::poisoned) > 0 || status.count(TaskState::missing) > 0) return kExitIncomplete;
  return status.in_progress() ? kExitInProgress : kExitIncomplete;
}

} // namespace kindling::app
