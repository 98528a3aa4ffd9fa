// Tests of Slurm's job scripts and answers, with shell scripts in place of Slurm's programs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/slurm_engine.h"

#include "tests/farm/test_farm.h"

#include <cstdlib>
#include <numeric>

namespace kindling::test {
namespace {

class Slurm : public FarmFolder {
 protected:
  Slurm() : path_(std::getenv("PATH")) {
    std::filesystem::create_directories(folder_ / "bin");
    setenv("PATH", ((folder_ / "bin").string() + ":" + path_).c_str(), 1);
  }
  ~Slurm() override { setenv("PATH", path_.c_str(), 1); }

  [[nodiscard]] static std::vector<int> all_tasks(const FarmPlan& plan) {
    std::vector<int> tasks(static_cast<size_t>(plan.task_count()));
    std::iota(tasks.begin(), tasks.end(), 0);
    return tasks;
  }

  std::string path_;
};

TEST(SlurmTime, ParsesAllFormsOfSlurm) {
  const std::vector<std::pair<const char*, int64_t>> times{
      {"1", 60},          {"90", 5400},     {"1:30", 120},       {"0:30", 60},          {"1:00:00", 3600},
      {"2-0", 2 * 86400}, {"2-12", 216000}, {"2-12:30", 217800}, {"2-12:30:01", 217860}};
  for (const auto& [text, seconds] : times) EXPECT_EQ(slurm_time_s(text), seconds) << text;
  for (const char* text :
       {"", "0", "0:00", "infinite", "UNLIMITED", "1:2:3:4", "-5", "1-", "a", "1:", "99999999999", "9999999-0"})
    EXPECT_EQ(slurm_time_s(text), std::nullopt) << text;
}

TEST(SlurmTime, WarningTakesAtMostAQuarter) {
  const auto warning = [](const char* time) { return time_warning_s({"", 0, "", time}); };
  EXPECT_EQ(warning(""), 60);
  EXPECT_EQ(warning("infinite"), 60);
  EXPECT_EQ(warning("2:00:00"), 60);
  EXPECT_EQ(warning("2"), 30);
  EXPECT_EQ(warning("1"), 15);
}

TEST_F(Slurm, ScriptsRequestResources) {
  FarmPlan plan = make_plan("", 3);
  plan.binary = "/opt/it's here/kindling";
  const std::vector<int> tasks{0, 1, 2};
  std::string script = slurm_array_script(plan, tasks);
  for (const char* wanted : {"#!/bin/sh\n", "--requeue\n", "--array=0-2\n", "--signal=B:USR1@60\n", "--exclusive\n",
                             "'/opt/it'\\''s here/kindling' farm work '", "\"$((0 + SLURM_ARRAY_TASK_ID))\"\n"})
    EXPECT_NE(script.find(wanted), std::string::npos) << wanted << "\n" << script;
  plan.resources = {"fast", 4, "8G", "1:00:00"};
  script = slurm_array_script(plan, tasks);
  for (const char* wanted : {"--partition=fast\n", "--cpus-per-task=4\n", "--mem=8G\n", "--time=1:00:00\n"})
    EXPECT_NE(script.find(wanted), std::string::npos) << wanted << "\n" << script;
  EXPECT_EQ(script.find("--exclusive"), std::string::npos);
  EXPECT_NE(slurm_merge_script(plan).find("farm merge '"), std::string::npos);
}

// Runs the script as the index-th task with `echo` as the program, which prints the task's number.
TEST_F(Slurm, ScriptsFindTheirTask) {
  FarmPlan plan = make_plan("", 20);
  write_script("show", "echo \"$4\"\n");
  plan.binary = folder_ / "show";
  const auto run = [&](const std::vector<int>& tasks, const char* index) {
    std::string script = slurm_array_script(plan, tasks);
    write_script("job", script);
    const std::string command = "SLURM_ARRAY_TASK_ID=" + std::string(index) + " " + (folder_ / "job").string();
    const std::string out = (folder_ / "out").string();
    EXPECT_EQ(std::system((command + " > " + out).c_str()), 0) << script;
    return read_text(out);
  };
  EXPECT_EQ(run({0, 1, 2}, "2"), "2\n");
  EXPECT_EQ(run({10, 11, 12}, "1"), "11\n");
  EXPECT_EQ(run({3, 7, 8, 19}, "0"), "3\n");
  EXPECT_EQ(run({3, 7, 8, 19}, "3"), "19\n");
}

TEST_F(Slurm, ParsesAnswers) {
  EXPECT_EQ(parse_sbatch("12\n").value(), "12");
  EXPECT_EQ(parse_sbatch("12;cluster\n").value(), "12");
  EXPECT_FALSE(parse_sbatch("").ok());
  EXPECT_FALSE(parse_sbatch("Submitted batch job 12").ok());
  EXPECT_EQ(parse_largest_array("A = 1\nMaxArraySize            = 4001\n"), 4001);
  EXPECT_EQ(parse_largest_array("nothing of it"), 1001);

  const FarmJobs jobs{{{"7", {0, 1, 2}}, {"8", {30, 31}}}, "9"};
  const FarmQueue queue = parse_squeue("7|0|RUNNING|node1|None\n7|2|PENDING||Resources\n8|1|COMPLETING|node2|None\n"
                                       "9|N/A|PENDING||Dependency\n5|0|RUNNING|node9|None\n7|99|RUNNING|x|y\nrubbish\n",
                                       jobs);
  ASSERT_EQ(queue.tasks.size(), 3u);
  EXPECT_EQ(queue.tasks.at(0).host, "node1");
  EXPECT_EQ(queue.tasks.at(2).state, QueueState::waiting);
  EXPECT_EQ(queue.tasks.at(2).reason, "Resources");
  EXPECT_EQ(queue.tasks.at(31).state, QueueState::running);
  EXPECT_TRUE(queue.merge);
}

TEST_F(Slurm, SubmitsArrayAndDependentMerge) {
  const FarmPlan plan = make_plan("", 5);
  write_script("bin/scontrol", "echo 'MaxArraySize = 2'\n");
  write_script("bin/sbatch",
               "echo \"$@\" >> " + (folder_ / "calls").string() + "; wc -l < " + (folder_ / "calls").string() + "\n");
  const Result<FarmJobs> jobs = SlurmEngine().submit(plan, all_tasks(plan));
  ASSERT_TRUE(jobs.ok()) << jobs.error().message;
  ASSERT_EQ(jobs.value().arrays.size(), 3u); // of two tasks at most
  EXPECT_EQ(jobs.value().arrays[1].id, "2");
  EXPECT_EQ(jobs.value().arrays[1].tasks, (std::vector<int>{2, 3}));
  EXPECT_EQ(jobs.value().merge_id, "4");
  EXPECT_NE(read_text(folder_ / "calls").find("--dependency=afterany:1:2:3 "), std::string::npos);
  ASSERT_TRUE(write_jobs(plan.folder, jobs.value()).ok());
  EXPECT_EQ(read_jobs(plan.folder).value().arrays[2].tasks, std::vector<int>{4});
}

TEST_F(Slurm, ErrorCancelsSubmittedJobs) {
  const FarmPlan plan = make_plan("", 2);
  write_script("bin/scontrol", "echo 'MaxArraySize = 1'\n");
  write_script("bin/scancel", "echo \"$@\" > " + (folder_ / "cancelled").string() + "\n");
  write_script("bin/sbatch", "[ -e " + (folder_ / "one").string() +
                                 " ] && { echo 'sbatch: error: no more' >&2; exit 1; }\ntouch " +
                                 (folder_ / "one").string() + "; echo 41\n");
  const Result<FarmJobs> jobs = SlurmEngine().submit(plan, all_tasks(plan));
  ASSERT_FALSE(jobs.ok());
  EXPECT_NE(jobs.error().message.find("no more"), std::string::npos) << jobs.error().message;
  EXPECT_EQ(read_text(folder_ / "cancelled"), "41\n");
}

TEST_F(Slurm, ReportsMissingPrograms) {
  setenv("PATH", (folder_ / "bin").c_str(), 1);
  const FarmPlan plan = make_plan("");
  const Result<FarmJobs> jobs = SlurmEngine().submit(plan, all_tasks(plan));
  ASSERT_FALSE(jobs.ok());
  EXPECT_NE(jobs.error().message.find("are Slurm's client programs installed"), std::string::npos)
      << jobs.error().message;
  EXPECT_EQ(jobs.error().kind, ErrorKind::input_output);
}

TEST_F(Slurm, RefusesResourcesWithSpaces) {
  EXPECT_TRUE(check_slurm_resources({"a,b", 2, "4G", "1-00:00:00"}).ok());
  EXPECT_FALSE(check_slurm_resources({"a b", 2, "", ""}).ok());
  EXPECT_FALSE(check_slurm_resources({"", 2, "4G\n#SBATCH --wrap=x", ""}).ok());
  for (const char* time : {"90", "0", "1:30", "1:30:00", "2-12", "2-12:30", "2-12:30:00", "UNLIMITED", "infinite"})
    EXPECT_TRUE(check_slurm_resources({"", 2, "", time}).ok()) << time;
  for (const char* time : {"soon", "1h", "-5", "1:2:3:4", "1-", "1-2:3:4:5", ":", "1:30:", "90 ", "5-x"})
    EXPECT_FALSE(check_slurm_resources({"", 2, "", time}).ok()) << time;
  for (const char* memory : {"4000", "4G", "512m", "0", "1T"})
    EXPECT_TRUE(check_slurm_resources({"", 2, memory, ""}).ok()) << memory;
  for (const char* memory : {"4GB", "4 G", "-4G", "G", "1.5G", "4X", "a lot"})
    EXPECT_FALSE(check_slurm_resources({"", 2, memory, ""}).ok()) << memory;
  for (const char* partition : {"gpu,", ",gpu", "--wrap=x", "a b", "gpu;ls", "a/b"})
    EXPECT_FALSE(check_slurm_resources({partition, 2, "", ""}).ok()) << partition;
  EXPECT_EQ(check_slurm_resources({"", 2, "4GB", ""}).error().message,
            "--memory: '4GB' is no value for Slurm; use a whole number of megabytes, or with a unit K, M, G or T: 4G");
}

} // namespace
} // namespace kindling::test
