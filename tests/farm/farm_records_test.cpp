// What follows from how attempts ended.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_records.h"

#include "tests/farm/test_farm.h"

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
  EXPECT_EQ(outcome_of(0, 0, false), AttemptOutcome::done);
  EXPECT_EQ(outcome_of(0, 0, true), AttemptOutcome::done); // the signal came too late
  EXPECT_EQ(outcome_of(1, 0, false), AttemptOutcome::failed);
  EXPECT_EQ(outcome_of(4, 0, false), AttemptOutcome::failed);
  EXPECT_EQ(outcome_of(2, 0, false), AttemptOutcome::refused);
  EXPECT_EQ(outcome_of(3, 0, false), AttemptOutcome::refused);
  EXPECT_EQ(outcome_of(130, 0, true), AttemptOutcome::interrupted);
  EXPECT_EQ(outcome_of(143, 0, false), AttemptOutcome::interrupted);
  EXPECT_EQ(outcome_of(139, 0, false), AttemptOutcome::crashed); // a shell's word for a signal
  EXPECT_EQ(outcome_of(0, 11, false), AttemptOutcome::crashed);
  EXPECT_EQ(outcome_of(0, 9, false), AttemptOutcome::crashed);
}

TEST(Verdict, FailuresAndCrashesAreRetriedSoOften) {
  using enum AttemptOutcome;
  EXPECT_EQ(judge(record_of({failed}), 2).step, NextStep::retry);
  EXPECT_EQ(judge(record_of({failed, crashed}), 2).step, NextStep::retry);
  const Verdict poison = judge(record_of({failed, crashed, failed}), 2);
  EXPECT_EQ(poison.step, NextStep::poison);
  EXPECT_NE(poison.reason.find("failed 3 times, last on node: exit code 4"), std::string::npos) << poison.reason;
  EXPECT_EQ(judge(record_of({crashed}), 0).step, NextStep::poison);
}

TEST(Verdict, InterruptionsCostNothing) {
  using enum AttemptOutcome;
  EXPECT_EQ(judge(record_of({interrupted, interrupted, interrupted, interrupted}), 0).step, NextStep::give_way);
  EXPECT_EQ(judge(record_of({interrupted, failed}), 1).step, NextStep::retry);
}

TEST(Verdict, LostMachinesAreNotThePartsFaultUntilTheyAreMany) {
  using enum AttemptOutcome;
  EXPECT_EQ(judge(record_of({lost}), 0).step, NextStep::retry);
  EXPECT_EQ(judge(record_of({lost, lost, lost, lost}), 0).step, NextStep::retry);
  EXPECT_EQ(judge(record_of({lost, lost, lost, lost, lost}), 0).step, NextStep::poison);
}

TEST(Verdict, RefusalsAreFinal) {
  EXPECT_EQ(judge(record_of({AttemptOutcome::refused}), 100).step, NextStep::refuse);
  EXPECT_EQ(judge(record_of({AttemptOutcome::done}), 0).step, NextStep::finished);
}

class Records : public FarmFolder {};

TEST_F(Records, AreReadAsTheyWereWritten) {
  TaskRecord record = record_of({AttemptOutcome::crashed, AttemptOutcome::done});
  record.attempts[0].message = "\xff broken UTF-8";
  record.attempts[1].start_s = 1700000000.25;
  record.attempts[1].resumed = true;
  record.poisoned = "why";
  ASSERT_TRUE(write_task_record(folder_ / "a.json", record).ok());
  const Result<TaskRecord> read = read_task_record(folder_ / "a.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().attempts.size(), 2u);
  EXPECT_EQ(read.value().attempts[0].outcome, AttemptOutcome::crashed);
  EXPECT_EQ(read.value().attempts[0].signal, 11);
  EXPECT_EQ(read.value().attempts[1].start_s, 1700000000.25);
  EXPECT_TRUE(read.value().attempts[1].resumed);
  EXPECT_EQ(read.value().poisoned, "why");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1); // nothing is left beside it
}

TEST_F(Records, ThatAreNotThereAreEmpty) {
  EXPECT_TRUE(read_task_record(folder_ / "a.json").value().attempts.empty());
  EXPECT_FALSE(read_refusal(folder_ / "a.json").value());
  EXPECT_FALSE(read_merge_record(folder_ / "a.json").value());
}

TEST_F(Records, ThatCannotBeWrittenSaySo) {
  const Result<void> written = write_refusal(folder_ / "nowhere" / "a.json", {3, 1, "bad"});
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().kind, ErrorKind::input_output);
}

} // namespace
} // namespace kindling::test
