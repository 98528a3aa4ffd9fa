// Slurm as a farm's engine: array jobs by sbatch, their state by squeue, retries by scontrol.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/distributed/farm_engine.h"

#include <cstdint>
#include <optional>

namespace kindling {

class SlurmEngine final : public FarmEngine {
 public:
  [[nodiscard]] Result<void> check(const FarmResources& resources) const override;
  [[nodiscard]] Result<FarmJobs> submit(const FarmPlan& plan, std::span<const int> tasks) override;
  [[nodiscard]] Result<FarmQueue> queue(const FarmJobs& jobs) override;
  [[nodiscard]] bool inside_task() const override;
  [[nodiscard]] Result<void> requeue_this_task() override;
  [[nodiscard]] int threads_of_this_task() const override;
  [[nodiscard]] std::string log_of_this_task() const override;
  [[nodiscard]] std::string host_of_this_task() const override;
};

// The functions below are parts of the engine that need no cluster.

// Returns the sbatch script of an array job whose indices 0 to tasks.size() - 1 are these tasks, in
// ascending order.
[[nodiscard]] std::string slurm_array_script(const FarmPlan& plan, std::span<const int> tasks);
[[nodiscard]] std::string slurm_merge_script(const FarmPlan& plan);
// Parses the job id from the output of sbatch --parsable: "12" or "12;cluster". Fails
// (input_output).
[[nodiscard]] Result<std::string> parse_sbatch(std::string_view output);
// Parses lines of kSqueueFormat; lines of other jobs are skipped.
inline constexpr std::string_view kSqueueFormat = "%F|%K|%T|%N|%r";
[[nodiscard]] FarmQueue parse_squeue(std::string_view output, const FarmJobs& jobs);
// Returns MaxArraySize from the output of `scontrol show config`, or Slurm's default 1001. Indices
// are below it.
[[nodiscard]] int parse_largest_array(std::string_view output);
// Returns the seconds of a time limit in Slurm's notation, rounded up to minutes as Slurm does:
// "90" (minutes), "1:30" (minutes and seconds), "1:30:00", "2-12", "2-12:30", "2-12:30:00". Nothing
// for an unlimited or invalid one.
[[nodiscard]] std::optional<int64_t> slurm_time_s(std::string_view text);
// Returns how many seconds before its limit a task is warned: enough for a checkpoint, but at most
// a quarter of the limit.
[[nodiscard]] int64_t time_warning_s(const FarmResources& resources);
// Checks the values of --partition, --memory and --time, which are copied into scripts, against
// Slurm's notation. Fails (usage).
[[nodiscard]] Result<void> check_slurm_resources(const FarmResources& resources);

} // namespace kindling
