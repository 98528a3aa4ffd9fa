// Slurm as a farm's engine: array jobs by sbatch, their state by squeue, another try by scontrol.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/distributed/farm_engine.h"

#include <cstdint>
#include <optional>

namespace kindling {

class SlurmEngine final : public FarmEngine {
 public:
  [[nodiscard]] Result<FarmJobs> submit(const FarmPlan& plan, std::span<const int> tasks) override;
  [[nodiscard]] Result<FarmQueue> queue(const FarmJobs& jobs) override;
  [[nodiscard]] bool inside_task() const override;
  [[nodiscard]] Result<void> requeue_this_task() override;
  [[nodiscard]] int threads_of_this_task() const override;
  [[nodiscard]] std::string log_of_this_task() const override;
  [[nodiscard]] std::string host_of_this_task() const override;
};

// The parts of it that need no cluster.

// A script for sbatch; indices 0 to tasks.size() - 1 of the array are these tasks.
[[nodiscard]] std::string slurm_array_script(const FarmPlan& plan, std::span<const int> tasks);
[[nodiscard]] std::string slurm_merge_script(const FarmPlan& plan);
// Job id from the output of sbatch --parsable: "12" or "12;cluster". Fails (input_output).
[[nodiscard]] Result<std::string> parse_sbatch(std::string_view output);
// From lines of kSqueueFormat; lines of other jobs are passed over.
inline constexpr std::string_view kSqueueFormat = "%F|%K|%T|%N|%r";
[[nodiscard]] FarmQueue parse_squeue(std::string_view output, const FarmJobs& jobs);
// The value of MaxArraySize in the output of `scontrol show config`: indices are below it; Slurm's default 1001 if it is not told.
[[nodiscard]] int parse_largest_array(std::string_view output);
// Seconds of a limit as Slurm writes it: "90" (minutes), "1:30" (minutes and seconds), "1:30:00", "2-12", "2-12:30", "2-12:30:00"; Slurm rounds
// them up to minutes. Nothing for one without an end, or what Slurm would not take.
[[nodiscard]] std::optional<int64_t> slurm_time_s(std::string_view text);
// How long before that limit a task is told: as long as a checkpoint may take, but not too much of a short time.
[[nodiscard]] int64_t time_warning_s(const FarmResources& resources);
// The words of --partition, --memory and --time go into scripts as they are; fails (usage).
[[nodiscard]] Result<void> check_slurm_resources(const FarmResources& resources);

} // namespace kindling
