// Interface of a farm's engine, which knows machines, queues and lost nodes but nothing of images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/distributed/farm_plan.h"

#include <csignal>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// An array of tasks that was submitted to the engine.
struct FarmArray {
  std::string id;         // assigned by the engine
  std::vector<int> tasks; // by index in the array
};
// All submitted jobs. The merge job starts once all tasks have ended, successfully or not.
struct FarmJobs {
  std::vector<FarmArray> arrays;
  std::string merge_id;
};
// Write and read DIR/jobs.json; without a file, read_jobs() returns no arrays. Fail (input_output).
[[nodiscard]] Result<void> write_jobs(const std::filesystem::path& folder, const FarmJobs& jobs);
[[nodiscard]] Result<FarmJobs> read_jobs(const std::filesystem::path& folder);

enum class QueueState { waiting, running };
struct QueuedTask {
  QueueState state = QueueState::waiting;
  std::string host;   // while running
  std::string reason; // for waiting, in the engine's words
};
// The jobs of a farm that the engine still knows; all others have ended.
struct FarmQueue {
  std::map<int, QueuedTask> tasks; // by number
  bool merge = false;              // the merge job waits or runs
};

// Signal that an engine may send to a task, but not to processes started by it, some time before
// its time limit.
inline constexpr int kOutOfTimeSignal = SIGUSR1;

class FarmEngine {
 public:
  virtual ~FarmEngine() = default;

  // Fails (usage) for resources that the engine would refuse. Runs no program.
  [[nodiscard]] virtual Result<void> check(const FarmResources& resources) const = 0;
  // Writes job scripts into the plan's folder and submits these tasks and a merge job that waits
  // for them. The engine restarts tasks of lost machines. Fails (usage) for invalid resources, and
  // (input_output) if the engine cannot be reached or refuses.
  [[nodiscard]] virtual Result<FarmJobs> submit(const FarmPlan& plan, std::span<const int> tasks) = 0;
  [[nodiscard]] virtual Result<FarmQueue> queue(const FarmJobs& jobs) = 0;

  // The functions below are for a process that is a task of this engine.
  [[nodiscard]] virtual bool inside_task() const = 0;
  // Asks for another start of the task, on any machine, after this process has ended; the engine
  // may send it SIGTERM.
  [[nodiscard]] virtual Result<void> requeue_this_task() = 0;
  [[nodiscard]] virtual int threads_of_this_task() const = 0;     // 0: all threads of the machine
  [[nodiscard]] virtual std::string log_of_this_task() const = 0; // relative to the plan's folder
  [[nodiscard]] virtual std::string host_of_this_task() const = 0;
};

// Makes the engine of that name: "slurm". Fails (usage) for any other.
[[nodiscard]] Result<std::unique_ptr<FarmEngine>> make_farm_engine(std::string_view name);

} // namespace kindling
