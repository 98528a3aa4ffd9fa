// The worker's loop of attempts at a task.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_worker.h"

#include "renderer/distributed/program_lines.h"
#include "renderer/distributed/run_process.h"
#include "renderer/session/accumulation_file.h"

#include <fmt/format.h>

#include <csignal>

namespace kindling {

namespace {

constexpr double kRecordInterval_s = 2.0; // between updates of the progress in the record

void remove_checkpoint(const FarmPlan& plan, const FarmTask& task) {
  std::error_code error;
  for (const char* ending : {"", ".previous", ".damaged", ".lock"})
    std::filesystem::remove(plan.checkpoint_file(task).string() + ending, error);
}

// Returns the fraction of the part's samples that an attempt would resume from, in [0, 1].
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
  // Marks attempts whose end was never recorded as lost: their machine failed, or they were killed.
  void close_lost_attempts();
  // Runs one attempt to its end and returns its exit code as a shell would.
  Result<int> attempt();
  Result<void> save() { return write_task_record(file_, record_); }
  Result<int> poison(const std::string& reason, int exit_code);
  Result<int> refuse(int exit_code);
  // Asks the engine for the next attempt. True if it agreed.
  bool leave_to_engine();
  // Asks the engine to resume the task in another process, unless this one was terminated.
  void request_resume();

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
    log_(fmt::format("{}; starting a new record", record.error().message)); // damaged, for example by a full disk
    record = TaskRecord{};
  }
  record_ = std::move(record).value();
  if (file_exists(plan_.part_file(task_))) {
    log_(fmt::format("{} is complete already", name));
    remove_checkpoint(plan_, task_);
    return 0;
  }
  if (!record_.poisoned.empty()) {
    log_(fmt::format("{} is given up: {}", name, record_.poisoned));
    return 1;
  }
  close_lost_attempts();
  if (const Verdict verdict = judge(record_, plan_.retries); verdict.step == NextStep::poison)
    return poison(verdict.reason, 1);

  for (;;) {
    const Result<std::optional<FarmRefusal>> refusal = read_refusal(plan_.refusal_file());
    if (!refusal.ok()) return refusal.error();
    if (refusal.value()) {
      log_(fmt::format("{} is not tried: task {} was refused: {}", name, refusal.value()->task,
                       refusal.value()->message));
      return refusal.value()->exit_code;
    }
    if (const int signal = signals_.received(); signal != 0) {
      if (signal == kOutOfTimeSignal) request_resume();
      return 128 + signal;
    }
    const Result<int> ended = attempt();
    if (!ended.ok()) return ended;
    const Verdict verdict = judge(record_, plan_.retries);
    switch (verdict.step) {
    case NextStep::finished: remove_checkpoint(plan_, task_); return 0;
    case NextStep::give_way: return ended;
    case NextStep::resume_later: request_resume(); return ended;
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
  const bool resumed = file_exists(plan_.checkpoint_file(task_));
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
    if (Result<void> saved = save(); !saved.ok()) log_(saved.error().message); // not fatal: the end is written later
  };
  // An interrupted render has left this file, and a render skips frames whose output exists.
  std::error_code error;
  std::filesystem::remove(plan_.unfinished_file(task_), error);
  const int threads = engine_.inside_task() ? engine_.threads_of_this_task() : plan_.resources.threads_per_part;
  Result<ProcessEnd> end = run_watched(render_command(plan_, task_, threads), plan_.working_folder, signals_, on_line);
  if (!end.ok()) { // not startable on this machine, perhaps on another
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
  // An unusable checkpoint must not block the next attempt: the render failed before it started to
  // take samples.
  if (resumed && attempt.exit_code == 4 && !lines.rendering) {
    log_("the checkpoint is unusable; the next attempt starts from scratch");
    remove_checkpoint(plan_, task_);
  }
  log_(fmt::format("attempt {}: {}", record_.attempts.size(), outcome_name(attempt.outcome)));
  if (Result<void> saved = save(); !saved.ok()) return saved.error();
  if (attempt.signal != 0) return 128 + attempt.signal;
  return attempt.outcome == AttemptOutcome::failed && attempt.exit_code == 0 ? 4 : attempt.exit_code;
}

Result<int> TaskWorker::poison(const std::string& reason, int exit_code) {
  record_.poisoned = reason;
  log_(fmt::format("{} is given up: {}", plan_.task_name(task_), reason));
  if (Result<void> saved = save(); !saved.ok()) return saved.error();
  return exit_code;
}

Result<int> TaskWorker::refuse(int exit_code) {
  std::string message = record_.attempts.back().message;
  if (message.empty()) message = fmt::format("the renderer ended with exit code {}", exit_code);
  log_("all other tasks of this farm are refused as well");
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

void TaskWorker::request_resume() {
  if (signals_.came(SIGTERM)) {
    log_("terminated as well: not requeued"); // cancelled, or past its time limit; the engine decides
    return;
  }
  if (!engine_.inside_task()) return;
  log_("resumes in another attempt: its time limit is near");
  if (const Result<void> requeued = engine_.requeue_this_task(); !requeued.ok()) log_(requeued.error().message);
}

} // namespace

Result<int> work_on_task(const FarmPlan& plan, int number, FarmEngine& engine, const FarmLog& log) {
  return TaskWorker(plan, number, engine, log).run();
}

} // namespace kindling
