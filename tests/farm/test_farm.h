// A farm in a temporary folder whose renderer is a shell script, and an engine that only counts.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/distributed/farm_engine.h"
#include "renderer/distributed/farm_plan.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace kindling::test {

class FarmFolder : public testing::Test {
 protected:
  FarmFolder();
  ~FarmFolder() override;

  // A plan of `parts` parts in folder_/farm, written, whose program is a script with this body. In it, $out is the part's or the
  // image's file and $checkpoint the checkpoint.
  [[nodiscard]] FarmPlan make_plan(const std::string& body, int parts = 2, std::vector<int> frames = {}) const;
  void write_script(const std::string& name, const std::string& body) const;
  [[nodiscard]] std::string read_text(const std::filesystem::path& path) const;

  std::filesystem::path folder_;
};

// Of no machines.
class CountingEngine final : public FarmEngine {
 public:
  bool inside = false;     // a task
  bool can_requeue = true; // else it says no
  int requeued = 0;

  Result<FarmJobs> submit(const FarmPlan&, std::span<const int> tasks) override {
    return FarmJobs{{{"1", {tasks.begin(), tasks.end()}}}, "2"};
  }
  Result<FarmQueue> queue(const FarmJobs&) override { return FarmQueue{}; }
  [[nodiscard]] bool inside_task() const override { return inside; }
  Result<void> requeue_this_task() override {
    if (!can_requeue) return Error{ErrorKind::input_output, "no"};
    ++requeued;
    return {};
  }
  [[nodiscard]] int threads_of_this_task() const override { return 3; }
  [[nodiscard]] std::string log_of_this_task() const override { return "logs/1_0.log"; }
  [[nodiscard]] std::string host_of_this_task() const override { return "here"; }
};

} // namespace kindling::test
