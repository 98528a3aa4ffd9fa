// Tests of attempts: their outcomes, the next step after each of them, and their records.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_records.h"

#include "renderer/distributed/farm_engine.h"
#include "tests/farm/test_farm.h"

#include <csignal>
#include <fstream>

namespace kindling::test {
namespace {

TaskRecord record_of(const std::vector<AttemptOutcome>& outcomes) {
  TaskRecord record;
  for (const AttemptOutcome outcome : outcomes) {
    FarmAttempt attempt;
    attempt.host = "node";
    attempt.outcome = outcome;
    attempt.exit_code = outcome == AttemptOutcome::failed ? 4 : 0;
    attempt.signal = outcome == AttemptOutcome::crashed ? 11 : 0;
    record.attempts.push_back(attempt);
  }
  return record;
}

TEST(Outcome, FollowsTheExitCode) {
  EXPECT_EQ(outcome_of(0, 0, 0), AttemptOutcome::done);
  EXPECT_EQ(outcome_of(0, 0, SIGTERM), AttemptOutcome::done); // the signal came too late
  EXPECT_EQ(outcome_of(1, 0, 0), AttemptOutcome::failed);
  EXPECT_EQ(outcome_of(4, 0, 0), AttemptOutcome::failed);
  EXPECT_EQ(outcome_of(2, 0, 0), AttemptOutcome::refused);
  EXPECT_EQ(outcome_of(3, 0, 0), AttemptOutcome::refused);
  EXPECT_EQ(outcome_of(130, 0, SIGTERM), AttemptOutcome::interrupted);
  EXPECT_EQ(outcome_of(143, 0, 0), AttemptOutcome::interrupted);
  EXPECT_EQ(outcome_of(129, 0, 0), AttemptOutcome::interrupted);
  EXPECT_EQ(outcome_of(139, 0, 0), AttemptOutcome::crashed); // a shell's exit code for a signal
  EXPECT_EQ(outcome_of(0, 11, 0), AttemptOutcome::crashed);
  EXPECT_EQ(outcome_of(0, 9, 0), AttemptOutcome::crashed);
  EXPECT_EQ(outcome_of(130, 0, kOutOfTimeSignal), AttemptOutcome::out_of_time);
  EXPECT_EQ(outcome_of(4, 0, kOutOfTimeSignal), AttemptOutcome::out_of_time); // no disk for its checkpoint
  EXPECT_EQ(outcome_of(0, 0, kOutOfTimeSignal), AttemptOutcome::done);
}

TEST(Verdict, FailuresAndCrashesAreRetriedUpToTheLimit) {
  using enum AttemptOutcome;
  EXPECT_EQ(judge(record_of({failed}), 2).step, NextStep::retry);
  EXPECT_EQ(judge(record_of({failed, crashed}), 2).step, NextStep::retry);
  const Verdict poison = judge(record_of({failed, crashed, failed}), 2);
  EXPECT_EQ(poison.step, NextStep::poison);
  EXPECT_NE(poison.reason.find("failed 3 times, last on node: exit code 4"), std::string::npos) << poison.reason;
  EXPECT_EQ(judge(record_of({crashed}), 0).step, NextStep::poison);
}

TEST(Verdict, InterruptionsUseNoRetry) {
  using enum AttemptOutcome;
  EXPECT_EQ(judge(record_of({interrupted, interrupted, interrupted, interrupted}), 0).step, NextStep::give_way);
  EXPECT_EQ(judge(record_of({interrupted, failed}), 1).step, NextStep::retry);
}

TEST(Verdict, LostMachinesUseNoRetryUntilTheyAreMany) {
  using enum AttemptOutcome;
  EXPECT_EQ(judge(record_of({lost}), 0).step, NextStep::retry);
  EXPECT_EQ(judge(record_of({lost, lost, lost, lost}), 0).step, NextStep::retry);
  EXPECT_EQ(judge(record_of({lost, lost, lost, lost, lost}), 0).step, NextStep::poison);
}

TEST(Verdict, OutOfTimeResumesWhileItMakesProgress) {
  // Attempts that ran out of time, by the fraction saved at their ends; each resumes the one
  // before.
  const auto verdict_of = [](const std::vector<double>& saved) {
    TaskRecord record = record_of(std::vector<AttemptOutcome>(saved.size(), AttemptOutcome::out_of_time));
    for (size_t i = 0; i < saved.size(); ++i) {
      record.attempts[i].saved_before = i > 0 ? saved[i - 1] : 0.0;
      record.attempts[i].saved = saved[i];
    }
    return judge(record, 0);
  };
  std::vector<double> slow;
  for (int i = 1; i <= 100; ++i) slow.push_back(0.001 * i);
  EXPECT_EQ(verdict_of(slow).step, NextStep::resume_later);
  EXPECT_EQ(verdict_of({0.0}).step, NextStep::resume_later);
  EXPECT_EQ(verdict_of({0.5, 0.5}).step, NextStep::resume_later); // a slow disk, once
  EXPECT_EQ(verdict_of({0.0, 0.1, 0.1, 0.2}).step, NextStep::resume_later);
  EXPECT_EQ(verdict_of({0.0, 0.0}).step, NextStep::poison);
  EXPECT_EQ(verdict_of({0.3, 0.2, 0.2}).step, NextStep::poison); // a checkpoint that was lost, too
  const Verdict poison = verdict_of({0.1, 0.5, 0.5, 0.5});
  EXPECT_EQ(poison.step, NextStep::poison);
  EXPECT_EQ(poison.reason,
            "out of time 2 times in a row without progress, 50.0 % of its samples are saved, last on node: "
            "it needs a longer --time");
  // Other outcomes in between neither count as one nor reset the count.
  TaskRecord record = record_of({AttemptOutcome::out_of_time, AttemptOutcome::lost, AttemptOutcome::out_of_time});
  EXPECT_EQ(judge(record, 0).step, NextStep::resume_later);
  record.attempts.push_back(record_of({AttemptOutcome::failed}).attempts[0]);
  EXPECT_EQ(judge(record, 0).step, NextStep::poison); // as a failure
  EXPECT_EQ(judge(record, 1).step, NextStep::retry);
}

TEST(Verdict, RefusalsAreFinal) {
  EXPECT_EQ(judge(record_of({AttemptOutcome::refused}), 100).step, NextStep::refuse);
  EXPECT_EQ(judge(record_of({AttemptOutcome::done}), 0).step, NextStep::finished);
}

class Records : public FarmFolder {};

TEST_F(Records, SurviveWritingAndReading) {
  TaskRecord record = record_of({AttemptOutcome::crashed, AttemptOutcome::done});
  record.attempts[0].message = "\xff broken UTF-8";
  record.attempts[1].start_s = 1700000000.25;
  record.attempts[1].resumed = true;
  record.attempts[1].saved_before = 1.0 / 3.0;
  record.attempts[1].saved = 0.7;
  record.poisoned = "why";
  ASSERT_TRUE(write_task_record(folder_ / "a.json", record).ok());
  const Result<TaskRecord> read = read_task_record(folder_ / "a.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().attempts.size(), 2u);
  EXPECT_EQ(read.value().attempts[0].outcome, AttemptOutcome::crashed);
  EXPECT_EQ(read.value().attempts[0].signal, 11);
  EXPECT_EQ(read.value().attempts[1].start_s, 1700000000.25);
  EXPECT_TRUE(read.value().attempts[1].resumed);
  EXPECT_EQ(read.value().attempts[1].saved_before, 1.0 / 3.0);
  EXPECT_EQ(read.value().attempts[1].saved, 0.7);
  EXPECT_EQ(read.value().poisoned, "why");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1); // no temporary file remains
}

TEST_F(Records, RefuseNumbersThatAnIntCannotHold) {
  ASSERT_TRUE(write_task_record(folder_ / "good.json", record_of({AttemptOutcome::crashed})).ok());
  const std::string good = read_text(folder_ / "good.json");
  for (const char* key : {"\"exit_code\": ", "\"signal\": "}) {
    const size_t at = good.find(key) + std::string_view(key).size();
    std::string bad = good;
    bad.replace(at, bad.find(',', at) - at, "1e300");
    std::ofstream(folder_ / "bad.json") << bad;
    const Result<TaskRecord> read = read_task_record(folder_ / "bad.json");
    ASSERT_FALSE(read.ok()) << key;
    EXPECT_NE(read.error().message.find(" is 1e+300; use a whole number"), std::string::npos) << read.error().message;
  }
  std::ofstream(folder_ / "merge.json") << R"({"end_s": 1, "exit_code": 4294967296, "message": ""})";
  EXPECT_FALSE(read_merge_record(folder_ / "merge.json").ok());
  std::ofstream(folder_ / "refused.json") << R"({"exit_code": 3, "task": -1e99, "message": ""})";
  EXPECT_FALSE(read_refusal(folder_ / "refused.json").ok());
  std::ofstream(folder_ / "jobs.json") << R"({"arrays": [{"id": "1", "tasks": [0, 3000000000]}], "merge": "2"})";
  const Result<FarmJobs> jobs = read_jobs(folder_);
  ASSERT_FALSE(jobs.ok());
  EXPECT_NE(jobs.error().message.find("'tasks' is 3000000000; use a whole number"), std::string::npos)
      << jobs.error().message;
}

TEST_F(Records, MissingFilesAreEmptyRecords) {
  EXPECT_TRUE(read_task_record(folder_ / "a.json").value().attempts.empty());
  EXPECT_FALSE(read_refusal(folder_ / "a.json").value());
  EXPECT_FALSE(read_merge_record(folder_ / "a.json").value());
}

TEST_F(Records, ReportsFilesThatCannotBeWritten) {
  const Result<void> written = write_refusal(folder_ / "nowhere" / "a.json", {3, 1, "bad"});
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().kind, ErrorKind::input_output);
}

} // namespace
} // namespace kindling::test
