// Reading, writing and judging of a farm's records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_records.h"

#include "renderer/distributed/farm_engine.h"
#include "renderer/distributed/json_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <system_error>

namespace kindling {

namespace {

constexpr std::array<std::string_view, 8> kOutcomeNames = {"running", "done",    "interrupted", "failed",
                                                           "crashed", "refused", "lost",        "out of time"};

AttemptOutcome outcome_from_name(std::string_view name) {
  const auto found = std::find(kOutcomeNames.begin(), kOutcomeNames.end(), name);
  return found == kOutcomeNames.end() ? AttemptOutcome::lost
                                      : static_cast<AttemptOutcome>(found - kOutcomeNames.begin());
}

nlohmann::ordered_json attempt_json(const FarmAttempt& attempt) {
  return {{"host", attempt.host},
          {"start_s", attempt.start_s},
          {"end_s", attempt.end_s},
          {"seen_s", attempt.seen_s},
          {"progress", attempt.progress},
          {"resumed", attempt.resumed},
          {"saved_before", attempt.saved_before},
          {"saved", attempt.saved},
          {"outcome", outcome_name(attempt.outcome)},
          {"exit_code", attempt.exit_code},
          {"signal", attempt.signal},
          {"message", attempt.message},
          {"log", attempt.log}};
}

FarmAttempt attempt_from_json(const nlohmann::ordered_json& json) {
  FarmAttempt attempt;
  attempt.host = json.at("host").get<std::string>();
  attempt.start_s = json.at("start_s").get<double>();
  attempt.end_s = json.at("end_s").get<double>();
  attempt.seen_s = json.at("seen_s").get<double>();
  attempt.progress = json.at("progress").get<double>();
  attempt.resumed = json.at("resumed").get<bool>();
  attempt.saved_before = json.at("saved_before").get<double>();
  attempt.saved = json.at("saved").get<double>();
  attempt.outcome = outcome_from_name(json.at("outcome").get<std::string>());
  attempt.exit_code = whole_number(json, "exit_code");
  attempt.signal = whole_number(json, "signal");
  attempt.message = json.at("message").get<std::string>();
  attempt.log = json.at("log").get<std::string>();
  return attempt;
}

// Returns `read` of the file's JSON object, or nothing if there is no file.
template <typename Read>
auto read_record(const std::filesystem::path& path, const Read& read)
    -> Result<std::optional<decltype(read(nlohmann::ordered_json()))>> {
  using Record = decltype(read(nlohmann::ordered_json()));
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::optional<Record>();
  Result<nlohmann::ordered_json> json = read_json_file(path);
  if (!json.ok()) return json.error();
  const auto broken = [&](std::string_view what) {
    return Error{ErrorKind::input_output, fmt::format("{}: not a record of a farm: {}", path.string(), what)};
  };
  try {
    return std::optional<Record>(read(json.value()));
  } catch (const NotAWholeNumber& wrong) {
    return broken(wrong.message);
  } catch (const nlohmann::json::exception& exception) {
    return broken(exception.what());
  }
}

// Returns the reason of a failed attempt in a few words.
std::string describe_failure(const FarmAttempt& attempt) {
  std::string text = attempt.signal != 0 ? fmt::format("ended by signal {}{}", attempt.signal,
                                                       attempt.signal == 9 ? " (out of memory?)" : "")
                                         : fmt::format("exit code {}", attempt.exit_code);
  if (!attempt.message.empty()) text += ": " + attempt.message;
  return text;
}

} // namespace

double now_s() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

bool file_exists(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}

std::string_view outcome_name(AttemptOutcome outcome) { return kOutcomeNames[static_cast<size_t>(outcome)]; }

int TaskRecord::count(AttemptOutcome outcome) const {
  return static_cast<int>(std::count_if(attempts.begin(), attempts.end(),
                                        [&](const FarmAttempt& attempt) { return attempt.outcome == outcome; }));
}

Verdict judge(const TaskRecord& record, int retries) {
  if (record.attempts.empty()) return {NextStep::retry, {}};
  const FarmAttempt& last = record.attempts.back();
  switch (last.outcome) {
  case AttemptOutcome::done: return {NextStep::finished, {}};
  case AttemptOutcome::interrupted: return {NextStep::give_way, {}};
  case AttemptOutcome::refused: return {NextStep::refuse, {}};
  case AttemptOutcome::out_of_time: {
    const auto progressed = std::find_if(record.attempts.rbegin(), record.attempts.rend(), [](const auto& attempt) {
      return attempt.outcome != AttemptOutcome::out_of_time || attempt.saved > attempt.saved_before;
    });
    const auto fruitless = progressed - record.attempts.rbegin();
    if (fruitless < kMaxFruitlessAttempts) return {NextStep::resume_later, {}};
    return {
        NextStep::poison,
        fmt::format("out of time {} times in a row without progress, {:.1f} % of its samples are saved, last on {}: "
                    "it needs a longer --time",
                    fruitless, 100.0 * last.saved, last.host)};
  }
  case AttemptOutcome::running:
  case AttemptOutcome::lost: {
    const int lost = record.count(AttemptOutcome::lost);
    if (lost < kMaxLostAttempts) return {NextStep::retry, {}};
    return {NextStep::poison, fmt::format("lost with its machine {} times, last on {}", lost, last.host)};
  }
  case AttemptOutcome::failed:
  case AttemptOutcome::crashed: break;
  }
  const int failures = record.count(AttemptOutcome::failed) + record.count(AttemptOutcome::crashed);
  if (failures <= retries) return {NextStep::retry, {}};
  return {NextStep::poison,
          fmt::format("failed {} times, last on {}: {}", failures, last.host, describe_failure(last))};
}

AttemptOutcome outcome_of(int exit_code, int signal, int asked_by) {
  if (signal == 0 && exit_code == 0) return AttemptOutcome::done;
  if (asked_by != 0) return asked_by == kOutOfTimeSignal ? AttemptOutcome::out_of_time : AttemptOutcome::interrupted;
  if (signal != 0) return AttemptOutcome::crashed;
  // 128 plus SIGHUP, SIGINT or SIGTERM: another process interrupted the render, which ended in
  // order. Other codes come from a shell in between that reports a crash.
  if (exit_code == 129 || exit_code == 130 || exit_code == 143) return AttemptOutcome::interrupted;
  if (exit_code > 128) return AttemptOutcome::crashed;
  return exit_code == 2 || exit_code == 3 ? AttemptOutcome::refused : AttemptOutcome::failed;
}

Result<TaskRecord> read_task_record(const std::filesystem::path& path) {
  Result<std::optional<TaskRecord>> record = read_record(path, [](const nlohmann::ordered_json& json) {
    TaskRecord task;
    for (const nlohmann::ordered_json& attempt : json.at("attempts"))
      task.attempts.push_back(attempt_from_json(attempt));
    task.poisoned = json.at("poisoned").get<std::string>();
    return task;
  });
  if (!record.ok()) return record.error();
  return record.value().value_or(TaskRecord{});
}

Result<void> write_task_record(const std::filesystem::path& path, const TaskRecord& record) {
  nlohmann::ordered_json json;
  json["attempts"] = nlohmann::ordered_json::array();
  for (const FarmAttempt& attempt : record.attempts) json["attempts"].push_back(attempt_json(attempt));
  json["poisoned"] = record.poisoned;
  return write_json_file(path, json);
}

Result<std::optional<MergeRecord>> read_merge_record(const std::filesystem::path& path) {
  return read_record(path, [](const nlohmann::ordered_json& json) {
    return MergeRecord{json.at("end_s").get<double>(), whole_number(json, "exit_code"),
                       json.at("message").get<std::string>()};
  });
}

Result<void> write_merge_record(const std::filesystem::path& path, const MergeRecord& record) {
  return write_json_file(path, {{"end_s", record.end_s}, {"exit_code", record.exit_code}, {"message", record.message}});
}

Result<std::optional<FarmRefusal>> read_refusal(const std::filesystem::path& path) {
  return read_record(path, [](const nlohmann::ordered_json& json) {
    return FarmRefusal{whole_number(json, "exit_code"), whole_number(json, "task"),
                       json.at("message").get<std::string>()};
  });
}

Result<void> write_refusal(const std::filesystem::path& path, const FarmRefusal& refusal) {
  return write_json_file(path,
                         {{"exit_code", refusal.exit_code}, {"task", refusal.task}, {"message", refusal.message}});
}

} // namespace kindling
