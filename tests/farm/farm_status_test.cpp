// Tests of the status of a farm, which combines records and queue.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_status.h"

#include "tests/farm/test_farm.h"

#include <fstream>

namespace kindling::test {
namespace {

class Status : public FarmFolder {
 protected:
  static void attempt(const FarmPlan& plan, int task, AttemptOutcome outcome, const std::string& poisoned = {}) {
    TaskRecord record;
    record.attempts.resize(1);
    record.attempts[0].host = "node1";
    record.attempts[0].outcome = outcome;
    record.attempts[0].progress = 0.25;
    record.poisoned = poisoned;
    ASSERT_TRUE(write_task_record(plan.task_record_file(plan.task(task)), record).ok());
  }
  [[nodiscard]] static std::vector<TaskState> states(const FarmStatus& status) {
    std::vector<TaskState> all;
    for (const FrameStatus& frame : status.frames)
      for (const TaskStatus& task : frame.tasks) all.push_back(task.state);
    return all;
  }
};

TEST_F(Status, CombinesPartsRecordsAndQueue) {
  using enum TaskState;
  const FarmPlan plan = make_plan("", 3, {1, 2});
  std::ofstream(plan.part_file(plan.task(0))) << "part";
  attempt(plan, 1, AttemptOutcome::running);
  attempt(plan, 2, AttemptOutcome::failed, "failed 3 times");
  attempt(plan, 3, AttemptOutcome::running); // on a lost machine
  FarmQueue queue;
  queue.tasks[1] = {QueueState::running, "node2", ""};
  queue.tasks[5] = {QueueState::waiting, "", "Resources"};
  const FarmStatus status = farm_status(plan, queue).value();
  EXPECT_EQ(states(status), (std::vector<TaskState>{done, running, poisoned, missing, missing, waiting}));
  EXPECT_EQ(status.frames[0].tasks[1].host, "node2");
  EXPECT_EQ(status.frames[0].tasks[1].progress, 0.25);
  EXPECT_EQ(status.frames[0].tasks[2].reason, "failed 3 times");
  EXPECT_NE(status.frames[1].tasks[0].reason.find("without a report on node1"), std::string::npos);
  EXPECT_TRUE(status.in_progress());
  EXPECT_FALSE(status.all_merged());
}

TEST_F(Status, UsesRecordsAloneWithoutEngine) {
  const FarmPlan plan = make_plan("", 2);
  attempt(plan, 0, AttemptOutcome::running);
  const FarmStatus status = farm_status(plan, std::nullopt).value();
  EXPECT_EQ(states(status), (std::vector<TaskState>{TaskState::running, TaskState::waiting}));
}

TEST_F(Status, RefusalAppliesToUnfinishedTasks) {
  const FarmPlan plan = make_plan("", 2);
  std::ofstream(plan.part_file(plan.task(0))) << "part";
  ASSERT_TRUE(write_refusal(plan.refusal_file(), {3, 1, "bad"}).ok());
  const FarmStatus status = farm_status(plan, FarmQueue{}).value();
  EXPECT_EQ(states(status), (std::vector<TaskState>{TaskState::done, TaskState::refused}));
  EXPECT_FALSE(status.in_progress());
}

TEST_F(Status, MergedFramesAreDone) {
  const FarmPlan plan = make_plan("", 1);
  ASSERT_TRUE(write_merge_record(plan.frame_record_file(0), {1.0, 4, "damaged"}).ok());
  EXPECT_FALSE(farm_status(plan, FarmQueue{}).value().all_merged());
  ASSERT_TRUE(write_merge_record(plan.frame_record_file(0), {1.0, 0, ""}).ok());
  EXPECT_TRUE(farm_status(plan, FarmQueue{}).value().all_merged());
}

} // namespace
} // namespace kindling::test
