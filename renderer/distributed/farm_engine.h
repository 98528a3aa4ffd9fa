// What a farm needs of a distributed engine. An engine knows machines, queues and lost nodes; it knows nothing of images.
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

// What the engine was given: arrays of tasks, and the job that merges once all of them have ended in whatever way.
struct FarmArray {
  std::string id;         // the engine's
  std::vector<int> tasks; // by index in the array
};
struct FarmJobs {
  std::vector<FarmArray> arrays;
  std::string merge_id;
};
// DIR/jobs.json. Fail (input_output); nothing submitted: no arrays.
[[nodiscard]] Result<void> write_jobs(const std::filesystem::path& folder, const FarmJobs& jobs);
[[nodiscard]] Result<FarmJobs> read_jobs(const std::filesystem::path& folder);

enum class QueueState { waiting, running };
struct QueuedTask {
  QueueState state = QueueState::waiting;
  std::string host;   // while running
  std::string reason; // why it waits, in the engine's words
};
// What the engine still has of a farm; what it does not have, has ended.
struct FarmQueue {
  std::map<int, QueuedTask> tasks; // by number
  bool merge = false;              // the merge job waits or runs
};

// What an engine may send to a task, and to nothing that the task has started, a while before its time is over.
inline constexpr int kOutOfTimeSignal = SIGUSR1;

class FarmEngine {
 public:
  virtual ~FarmEngine() = default;

  // Writes job scripts into the plan's folder and hands these tasks over, with the merge job behind them. Tasks of machines that
  // go away are started again by the engine. Fails (usage) for resources it cannot understand, (input_output) where the engine
  // cannot be reached or says no.
  [[nodiscard]] virtual Result<FarmJobs> submit(const FarmPlan& plan, std::span<const int> tasks) = 0;
  [[nodiscard]] virtual Result<FarmQueue> queue(const FarmJobs& jobs) = 0;

  // For a process that is a task of this engine:
  [[nodiscard]] virtual bool inside_task() const = 0;
  // Have the task started again, elsewhere if need be, once this process has ended; the engine may end it by SIGTERM.
  [[nodiscard]] virtual Result<void> requeue_this_task() = 0;
  [[nodiscard]] virtual int threads_of_this_task() const = 0;     // 0: all of the machine
  [[nodiscard]] virtual std::string log_of_this_task() const = 0; // from the plan's folder
  [[nodiscard]] virtual std::string host_of_this_task() const = 0;
};

// "slurm". Fails (usage).
[[nodiscard]] Result<std::unique_ptr<FarmEngine>> make_farm_engine(std::string_view name);

} // namespace kindling
