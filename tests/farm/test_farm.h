// A farm in a temporary folder with a shell script as renderer, and an engine that counts.
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

  // Writes a plan of `parts` parts to folder_/farm whose program is a script with this body, and
  // returns it. In the script $out is the file of the part or image, and $checkpoint the
  // checkpoint.
  [[nodiscard]] FarmPlan make_plan(const std::string& body, int parts = 2, std::vector<int> frames = {}) const;
  void write_script(const std::string& name, const std::string& body) const;
  [[nodiscard]] std::string read_text(const std::filesystem::path& path) const;

  std::filesystem::path folder_;
};

// An engine without machines.
class CountingEngine final : public FarmEngine {
 public:
  bool inside = false;     // true within a task
  bool can_requeue = true; // false: it refuses
  int requeued = 0;

  [[nodiscard]] Result<void> check(const FarmResources&) const override { return {}; }
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
