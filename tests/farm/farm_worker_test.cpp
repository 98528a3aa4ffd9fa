// Tests of the farm worker, with shell scripts in place of the renderer.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_worker.h"

#include "renderer/session/accumulation_file.h"
#include "tests/farm/test_farm.h"

#include <signal.h>
#include <unistd.h>

#include <fstream>

namespace kindling::test {
namespace {

class Worker : public FarmFolder {
 protected:
  int work(const FarmPlan& plan, int task = 0) {
    const Result<int> code =
        work_on_task(plan, task, engine_, [&](std::string_view line) { log_ += std::string(line) + "\n"; });
    EXPECT_TRUE(code.ok()) << (code.ok() ? "" : code.error().message);
    return code.ok() ? code.value() : -1;
  }
  [[nodiscard]] static TaskRecord record(const FarmPlan& plan, int task = 0) {
    return read_task_record(plan.task_record_file(plan.task(task))).value();
  }

  CountingEngine engine_;
  std::string log_;
};

TEST_F(Worker, RendersPartAndRecordsProgress) {
  const FarmPlan plan = make_plan(R"(echo '{"event":"progress","phase":"render","fraction":0.5}' >&2
echo some words
[ -e "$checkpoint" ] || touch "$checkpoint"
echo "part $part" > "$out"
)");
  EXPECT_EQ(work(plan, 1), 0);
  EXPECT_EQ(read_text(plan.part_file(plan.task(1))), "part 2/2\n");
  const TaskRecord done = record(plan, 1);
  ASSERT_EQ(done.attempts.size(), 1u);
  EXPECT_EQ(done.attempts[0].outcome, AttemptOutcome::done);
  EXPECT_EQ(done.attempts[0].host, "here");
  EXPECT_EQ(done.attempts[0].progress, 1.0);
  EXPECT_GE(done.attempts[0].end_s, done.attempts[0].start_s);
  EXPECT_NE(log_.find("some words"), std::string::npos);
  EXPECT_EQ(log_.find("progress"), std::string::npos) << log_;
  EXPECT_FALSE(std::filesystem::exists(plan.checkpoint_file(plan.task(1)))); // removed once the part is whole

  EXPECT_EQ(work(plan, 1), 0); // the part exists already
  EXPECT_EQ(record(plan, 1).attempts.size(), 1u);
}

TEST_F(Worker, RetriesInPlaceWithoutEngine) {
  const FarmPlan plan = make_plan(R"(echo x >> tries
[ $(wc -l < tries) -lt 3 ] && { echo "kindling: error: too early" >&2; exit 4; }
touch "$out"
)");
  EXPECT_EQ(work(plan), 0);
  const TaskRecord tried = record(plan);
  ASSERT_EQ(tried.attempts.size(), 3u);
  EXPECT_EQ(tried.attempts[0].outcome, AttemptOutcome::failed);
  EXPECT_EQ(tried.attempts[0].message, "too early");
  EXPECT_EQ(engine_.requeued, 0);
}

TEST_F(Worker, LeavesNextAttemptToEngine) {
  engine_.inside = true;
  const FarmPlan plan = make_plan("exit 1\n");
  EXPECT_EQ(work(plan), 1);
  EXPECT_EQ(engine_.requeued, 1);
  EXPECT_EQ(record(plan).attempts.size(), 1u);
  EXPECT_EQ(record(plan).attempts[0].log, "logs/1_0.log");
  EXPECT_EQ(work(plan), 1);
  EXPECT_EQ(engine_.requeued, 2);
  EXPECT_EQ(work(plan), 1); // the third is the last of two retries
  EXPECT_EQ(engine_.requeued, 2);
  EXPECT_NE(record(plan).poisoned.find("failed 3 times"), std::string::npos);
  EXPECT_EQ(work(plan), 1); // it stays poisoned
  EXPECT_EQ(record(plan).attempts.size(), 3u);
}

TEST_F(Worker, RetriesInPlaceIfEngineRefuses) {
  engine_.inside = true;
  engine_.can_requeue = false;
  const FarmPlan plan = make_plan("kill -SEGV $$\n");
  EXPECT_EQ(work(plan), 128 + SIGSEGV);
  ASSERT_EQ(record(plan).attempts.size(), 3u);
  EXPECT_EQ(record(plan).attempts[2].outcome, AttemptOutcome::crashed);
  EXPECT_EQ(record(plan).attempts[2].signal, SIGSEGV);
  EXPECT_NE(record(plan).poisoned.find("signal 11"), std::string::npos) << record(plan).poisoned;
}

TEST_F(Worker, BadSceneStopsWholeFarm) {
  const FarmPlan plan = make_plan("echo x >> tries; echo 'kindling: error: scene.glb: is no good' >&2; exit 3\n");
  EXPECT_EQ(work(plan, 0), 3);
  EXPECT_EQ(work(plan, 1), 3);
  EXPECT_EQ(read_text(folder_ / "tries"), "x\n"); // one attempt of one task
  const std::optional<FarmRefusal> refusal = read_refusal(plan.refusal_file()).value();
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->exit_code, 3);
  EXPECT_EQ(refusal->message, "scene.glb: is no good");
}

TEST_F(Worker, ForwardsTerminationAndExits) {
  engine_.inside = true;
  // Like the renderer, it ends in good order on SIGINT. The SIGTERM that an engine sends to all
  // processes must not reach it. (Not a shell, which would unblock the signal.)
  const FarmPlan plan = make_plan(R"(export checkpoint out; exec python3 -c '
import os, signal, sys, time
def save(*_):
    open(os.environ["checkpoint"], "w").write("saved")
    open(os.environ["out"], "w").write("some samples")
    sys.exit(130)
signal.signal(signal.SIGINT, save)
os.kill(os.getpid(), signal.SIGTERM)
os.kill(os.getppid(), signal.SIGTERM)
time.sleep(60)
')");
  EXPECT_EQ(work(plan), 130);
  ASSERT_EQ(record(plan).attempts.size(), 1u);
  EXPECT_EQ(record(plan).attempts[0].outcome, AttemptOutcome::interrupted);
  EXPECT_EQ(engine_.requeued, 0); // the sender of the signal requeues
  EXPECT_TRUE(std::filesystem::exists(plan.checkpoint_file(plan.task(0))));
  EXPECT_FALSE(std::filesystem::exists(plan.part_file(plan.task(0)))); // an incomplete part gets no file

  FarmPlan second = plan;
  write_script("second", "[ \"$(cat " + plan.checkpoint_file(plan.task(0)).string() +
                             ")\" = saved ] || exit 1\ntouch " + plan.unfinished_file(plan.task(0)).string() + "\n");
  second.binary = folder_ / "second";
  EXPECT_EQ(work(second), 0);
  EXPECT_TRUE(record(plan).attempts[1].resumed);
}

// Writes a checkpoint with this many of four samples.
void write_checkpoint(const std::filesystem::path& path, uint32_t samples) {
  const PixelRect area{V2i(0), V2i(8)};
  AccumulationIdentity identity;
  identity.size_px = V2i(8);
  identity.crop = area;
  identity.samples_per_pixel = 4;
  identity.part = {0, 4};
  RenderState state{Film(V2i(8), area, {}), Coverage(area), {}, {}};
  ASSERT_TRUE(samples == 0 || state.coverage.add(0, {0, samples}));
  const Result<void> written = write_accumulation(path, identity, state, false);
  ASSERT_TRUE(written.ok()) << written.error().message;
}

// A renderer that copies the file "save" to its checkpoint on SIGINT. It sends its parent the
// warning that its time is nearly over; the same signal to itself has no effect. `more` may send
// further signals before SIGINT, the answer of the parent, is unblocked.
std::string slow_renderer(const std::string& more = "") {
  return R"(export checkpoint out; exec python3 -c '
import os, shutil, signal, sys, time
def save(*_):
    if os.path.exists("save"): shutil.copy("save", os.environ["checkpoint"])
    sys.exit(130)
signal.signal(signal.SIGINT, save)
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
os.kill(os.getpid(), signal.SIGUSR1)
os.kill(os.getppid(), signal.SIGUSR1)
)" + more +
         R"(signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
time.sleep(60)
'
)";
}

TEST_F(Worker, OutOfTimeResumesInAnotherAttempt) {
  engine_.inside = true;
  const FarmPlan plan = make_plan(slow_renderer());
  for (const uint32_t samples : {1U, 2U, 3U}) {
    write_checkpoint(folder_ / "save", samples);
    EXPECT_EQ(work(plan), 130);
    EXPECT_EQ(engine_.requeued, static_cast<int>(samples));
    const FarmAttempt last = record(plan).attempts.back();
    EXPECT_EQ(last.outcome, AttemptOutcome::out_of_time);
    EXPECT_EQ(last.resumed, samples > 1);
    EXPECT_EQ(last.saved_before, 0.25 * (samples - 1));
    EXPECT_EQ(last.saved, 0.25 * samples);
  }
  EXPECT_TRUE(record(plan).poisoned.empty());
  EXPECT_NE(log_.find("resumes in another attempt"), std::string::npos) << log_;
  FarmPlan second = plan;
  write_script("second", "touch " + plan.unfinished_file(plan.task(0)).string() + "\n");
  second.binary = folder_ / "second";
  EXPECT_EQ(work(second), 0);
  EXPECT_EQ(record(plan).attempts.size(), 4u);
  EXPECT_EQ(record(plan).attempts.back().saved, 1.0);
}

TEST_F(Worker, OutOfTimeWithoutProgressIsPoison) {
  engine_.inside = true;
  const FarmPlan plan = make_plan(slow_renderer());
  EXPECT_EQ(work(plan), 130); // nothing is saved before the first sample
  EXPECT_EQ(engine_.requeued, 1);
  EXPECT_EQ(work(plan), 130);
  EXPECT_EQ(engine_.requeued, 1);
  EXPECT_NE(record(plan).poisoned.find("out of time 2 times in a row"), std::string::npos) << record(plan).poisoned;
  EXPECT_EQ(work(plan), 1); // not tried again
  EXPECT_EQ(record(plan).attempts.size(), 2u);

  write_checkpoint(folder_ / "save", 2);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(work(plan, 1), 130);
  EXPECT_EQ(engine_.requeued, 3); // by the first and the second attempt
  EXPECT_NE(record(plan, 1).poisoned.find("50.0 % of its samples are saved"), std::string::npos)
      << record(plan, 1).poisoned;
}

TEST_F(Worker, TerminationAfterWarningIsNotRequeued) {
  engine_.inside = true;
  const FarmPlan plan = make_plan(slow_renderer("os.kill(os.getppid(), signal.SIGTERM)\n"));
  write_checkpoint(folder_ / "save", 1);
  EXPECT_EQ(work(plan), 130);
  EXPECT_EQ(engine_.requeued, 0);
  EXPECT_EQ(record(plan).attempts.size(), 1u);
  EXPECT_TRUE(std::filesystem::exists(plan.checkpoint_file(plan.task(0))));
}

TEST_F(Worker, OutOfTimeWithoutEngineExits) {
  const FarmPlan plan = make_plan(slow_renderer());
  write_checkpoint(folder_ / "save", 1);
  EXPECT_EQ(work(plan), 130);
  EXPECT_EQ(record(plan).attempts.size(), 1u);
  engine_.inside = true;
  engine_.can_requeue = false;
  write_checkpoint(folder_ / "save", 2);
  EXPECT_EQ(work(plan), 130); // no retry in place: its time is over
  EXPECT_EQ(record(plan).attempts.size(), 2u);
}

TEST_F(Worker, AttemptWithoutEndCountsAsLost) {
  const FarmPlan plan = make_plan("touch \"$out\"\n");
  TaskRecord before;
  before.attempts.resize(1);
  before.attempts[0].host = "elsewhere";
  ASSERT_TRUE(write_task_record(plan.task_record_file(plan.task(0)), before).ok());
  EXPECT_EQ(work(plan), 0);
  ASSERT_EQ(record(plan).attempts.size(), 2u);
  EXPECT_EQ(record(plan).attempts[0].outcome, AttemptOutcome::lost);
}

TEST_F(Worker, RendererWithoutOutputFails) {
  FarmPlan plan = make_plan("exit 0\n");
  plan.retries = 0;
  EXPECT_EQ(work(plan), 4);
  EXPECT_EQ(record(plan).attempts[0].outcome, AttemptOutcome::failed);
}

TEST_F(Worker, UnreadableCheckpointDoesNotBlockRetry) {
  FarmPlan plan = make_plan("[ -e \"$checkpoint\" ] && exit 4\ntouch \"$out\"\n");
  std::ofstream(plan.checkpoint_file(plan.task(0))) << "damaged";
  EXPECT_EQ(work(plan), 0);
  EXPECT_EQ(record(plan).attempts.size(), 2u);
}

TEST_F(Worker, MergesCompleteFrames) {
  const FarmPlan plan = make_plan("echo merged >> \"$out\"\n", 2, {1, 2});
  for (const int task : {0, 1, 2}) std::ofstream(plan.part_file(plan.task(task))) << "part";
  TaskRecord poisoned;
  poisoned.poisoned = "failed 3 times";
  ASSERT_TRUE(write_task_record(plan.task_record_file(plan.task(3)), poisoned).ok());
  const FarmLog nothing = [](std::string_view) {};
  Result<MergeReport> report = merge_frames(plan, nothing);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report.value().merged, 1);
  EXPECT_EQ(report.value().exit_code, 0);
  ASSERT_EQ(report.value().bad.size(), 1u);
  EXPECT_NE(report.value().bad[0].find("frame 2: part 2/2 poisoned: failed 3 times"), std::string::npos)
      << report.value().bad[0];
  EXPECT_EQ(read_text(folder_ / "image.0001.exr"), "merged\n");

  std::ofstream(plan.part_file(plan.task(3))) << "part";
  report = merge_frames(plan, nothing);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report.value().merged, 1);
  EXPECT_EQ(report.value().already, 1);
  EXPECT_TRUE(report.value().bad.empty());
  EXPECT_EQ(read_text(folder_ / "image.0001.exr"), "merged\n"); // once
}

TEST_F(Worker, ReportsFailedMerge) {
  const FarmPlan plan = make_plan("echo 'kindling: error: part 1 is damaged' >&2; exit 4\n", 1);
  std::ofstream(plan.part_file(plan.task(0))) << "part";
  const Result<MergeReport> report = merge_frames(plan, [](std::string_view) {});
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report.value().exit_code, 4);
  EXPECT_NE(report.value().bad.at(0).find("part 1 is damaged"), std::string::npos);
}

} // namespace
} // namespace kindling::test
