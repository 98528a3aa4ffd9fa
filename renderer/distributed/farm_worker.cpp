// Attempts at a task, one after the other.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_worker.h"

#include "renderer/distributed/program_lines.h"
#include "renderer/distributed/run_process.h"
#include "renderer/session/accumulation_file.h"

#include <fmt/format.h>

#include <csignal>

namespace kindling {

namespace {

// How often the progress of a render goes to its record.
constexpr double kRecordInterval_s = 2.0;

void remove_checkpoint(const FarmPlan& plan, const FarmTask& task) {
  std::error_code error;
  for (const char* ending : {"", ".previous", ".damaged", ".lock"})
    std::filesystem::remove(plan.checkpoint_file(task).string() + ending, error);
}

// Of the samples that the part is to have, the share that an attempt would go on from.
double saved_share(const FarmPlan& plan, const FarmTask& task) {
  const std::filesystem::path checkpoint = plan.checkpoint_file(task);
  Result<AccumulationSummary> summary = read_accumulation_summary(checkpoint);
  if (!summary.ok()) summary = read_accumulation_summary(previous_accumulation(checkpoint));
  return summary.ok() ? summary.value().coverage.done_share(summary.value().identity.part) : 0.0;
}

class TaskWorker {
 public:
  TaskWorker(const FarmPlan& plan, int number, FarmEngine& engine, const FarmLog& log)
      : plan_(plan), task_(plan.task(number)), engine_(engine), log_(log), file_(plan.task_record_file(task_)) {}

  Result<int> run();

 private:
  // Ends attempts that ended without a word: with their machine, or killed.
  void close_lost_attempts();
  // One attempt to its end; its exit code, as of a shell.
  Result<int> attempt();
  Result<void> save() { return write_task_record(file_, record_); }
  Result<int> poison(const std::string& reason, int exit_code);
  Result<int> refuse(int exit_code);
  // Whether the next attempt is another process's.
  bool leave_to_engine();
  // As a matter of another process alone.
  void go_on_later();

  const FarmPlan& plan_;
  const FarmTask task_;
  FarmEngine& engine_;
  const FarmLog& log_;
  const std::filesystem::path file_;
  TaskRecord record_;
  SignalInbox signals_;
};

Result<int> TaskWorker::run() {
  const std::string name = plan_.task_name(task_);
  Result<TaskRecord> record = read_task_record(file_);
  if (!record.ok()) {
    log_(fmt::format("{}; beginning a new record", record.error().message)); // a full disk's, or a broken one's
    record = TaskRecord{};
  }
  record_ = std::move(record).value();
  if (is_there(plan_.part_file(task_))) {
    log_(fmt::format("{} is there already", name));
    remove_checkpoint(plan_, task_);
    return 0;
  }
  if (!record_.poisoned.empty()) {
    log_(fmt::format("{} is not tried any more: {}", name, record_.poisoned));
    return 1;
  }
  close_lost_attempts();
  if (const Verdict verdict = judge(record_, plan_.retries); verdict.step == NextStep::poison)
    return poison(verdict.reason, 1);

  for (;;) {
    const Result<std::optional<FarmRefusal>> refusal = read_refusal(plan_.refusal_file());
    if (!refusal.ok()) return refusal.error();
    if (refusal.value()) {
      log_(
          fmt::format("{} is not tried: task {} found out: {}", name, refusal.value()->task, refusal.value()->message));
      return refusal.value()->exit_code;
    }
    if (const int signal = signals_.received(); signal != 0) {
      if (signal == kOutOfTimeSignal) go_on_later();
      return 128 + signal;
    }
    const Result<int> ended = attempt();
    if (!ended.ok()) return ended;
    const Verdict verdict = judge(record_, plan_.retries);
    switch (verdict.step) {
    case NextStep::finished: remove_checkpoint(plan_, task_); return 0;
    case NextStep::give_way: return ended;
    case NextStep::go_on: go_on_later(); return ended;
    case NextStep::refuse: return refuse(ended.value());
    case NextStep::poison: return poison(verdict.reason, ended.value());
    case NextStep::retry:
      if (leave_to_engine()) return ended;
    }
  }
}

void TaskWorker::close_lost_attempts() {
  for (FarmAttempt& attempt : record_.attempts)
    if (attempt.outcome == AttemptOutcome::running) {
      attempt.outcome = AttemptOutcome::lost;
      attempt.end_s = attempt.seen_s > 0.0 ? attempt.seen_s : attempt.start_s;
      log_(fmt::format("an earlier attempt was lost with {}", attempt.host));
    }
}

Result<int> TaskWorker::attempt() {
  const bool resumed = is_there(plan_.checkpoint_file(task_));
  FarmAttempt& attempt = record_.attempts.emplace_back();
  attempt.host = engine_.host_of_this_task();
  attempt.start_s = now_s();
  attempt.resumed = resumed;
  attempt.saved_before = saved_share(plan_, task_);
  attempt.log = engine_.log_of_this_task();
  if (Result<void> saved = save(); !saved.ok()) return saved.error();
  log_(fmt::format("{} of {}: attempt {} on {}{}", plan_.task_name(task_), plan_.parts, record_.attempts.size(),
                   attempt.host, resumed ? ", from its checkpoint" : ""));

  ProgramLines lines(log_);
  const auto on_line = [&](std::string_view line) {
    if (!lines.take(line) || now_s() - attempt.seen_s < kRecordInterval_s) return;
    attempt.seen_s = now_s();
    attempt.progress = lines.progress;
    if (Result<void> saved = save(); !saved.ok()) log_(saved.error().message); // the end will be written
  };
  // A render that is interrupted writes what it has; and frames whose file is there are skipped.
  std::error_code error;
  std::filesystem::remove(plan_.unfinished_file(task_), error);
  const int threads = engine_.inside_task() ? engine_.threads_of_this_task() : plan_.resources.threads_per_part;
  Result<ProcessEnd> end = run_watched(render_command(plan_, task_, threads), plan_.working_folder, signals_, on_line);
  if (!end.ok()) { // no program on this machine: another one may have it
    end = ProcessEnd{4, 0};
    lines.error = "the program cannot be started";
  }

  attempt.end_s = now_s();
  attempt.exit_code = end.value().exit_code;
  attempt.signal = end.value().signal;
  attempt.progress = lines.progress;
  attempt.message = lines.error;
  attempt.outcome = outcome_of(end.value().exit_code, end.value().signal, signals_.received());
  if (attempt.outcome == AttemptOutcome::done) {
    std::filesystem::rename(plan_.unfinished_file(task_), plan_.part_file(task_), error);
    if (error) {
      attempt.outcome = AttemptOutcome::failed;
      attempt.message = fmt::format("{}: {}", plan_.unfinished_file(task_).string(), error.message());
    }
  }
  attempt.saved = attempt.outcome == AttemptOutcome::done ? 1.0 : saved_share(plan_, task_);
  if (attempt.outcome == AttemptOutcome::done) attempt.progress = 1.0;
  // A checkpoint that cannot be gone on from must not be in the way of the next attempt; one that could is worth keeping.
  if (resumed && attempt.exit_code == 4 && !lines.rendering) {
    log_("the next attempt will begin anew");
    remove_checkpoint(plan_, task_);
  }
  log_(fmt::format("attempt {}: {}", record_.attempts.size(), outcome_name(attempt.outcome)));
  if (Result<void> saved = save(); !saved.ok()) return saved.error();
  if (attempt.signal != 0) return 128 + attempt.signal;
  return attempt.outcome == AttemptOutcome::failed && attempt.exit_code == 0 ? 4 : attempt.exit_code;
}

Result<int> TaskWorker::poison(const std::string& reason, int exit_code) {
  record_.poisoned = reason;
  log_(fmt::format("{} is not tried any more: {}", plan_.task_name(task_), reason));
  if (Result<void> saved = save(); !saved.ok()) return saved.error();
  return exit_code;
}

Result<int> TaskWorker::refuse(int exit_code) {
  std::string message = record_.attempts.back().message;
  if (message.empty()) message = fmt::format("the renderer ended with exit code {}", exit_code);
  log_("no task of this farm is tried any more");
  if (Result<void> written = write_refusal(plan_.refusal_file(), {exit_code, task_.number, message}); !written.ok())
    return written.error();
  return exit_code;
}

bool TaskWorker::leave_to_engine() {
  if (!engine_.inside_task()) return false;
  const Result<void> requeued = engine_.requeue_this_task();
  if (!requeued.ok()) log_(fmt::format("{}; trying again here", requeued.error().message));
  return requeued.ok();
}

void TaskWorker::go_on_later() {
  if (signals_.came(SIGTERM)) {
    log_("and terminated: whoever does that says whether it goes on"); // cancelled, or the time is over already
    return;
  }
  if (!engine_.inside_task()) return;
  log_("goes on in another attempt: its time is nearly over");
  if (const Result<void> requeued = engine_.requeue_this_task(); !requeued.ok()) log_(requeued.error().message);
}

} // namespace

Result<int> work_on_task(const FarmPlan& plan, int number, FarmEngine& engine, const FarmLog& log) {
  return TaskWorker(plan, number, engine, log).run();
}

} // namespace kindling
