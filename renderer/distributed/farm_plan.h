// A farm's plan: one scene, its frames, each in parts, and how to render and to merge them. A folder that all machines share holds
// the plan and everything that becomes of it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// What an engine is asked for, each task the same; empty or 0: the engine's own default.
struct FarmResources {
  std::string partition;
  int threads_per_part = 0; // 0: a part has a machine to itself
  std::string memory;       // as Slurm writes it: "4G"
  std::string time;         // the longest that an attempt may take, as Slurm writes it: "2:00:00"
};

// Which part of which frame a task renders.
struct FarmTask {
  int number = 0;           // from 0, frame by frame
  std::optional<int> frame; // unset: a plan without frames
  int part = 1;             // from 1
};

struct FarmPlan {
  std::string program;                  // version of the program that made the plan
  std::filesystem::path binary;         // absolute; the same on all machines
  std::filesystem::path folder;         // absolute: of the farm
  std::filesystem::path scene;          // absolute
  std::filesystem::path working_folder; // absolute: where relative paths in `flags` begin
  std::vector<std::string> flags;       // of `render`, none of those that the farm sets itself
  std::vector<int> frames;              // empty: one image, no animation
  int parts = 1;
  std::vector<std::filesystem::path> outputs; // absolute; with frames, #### is the frame's number
  int retries = 2;                            // of a part, after its first attempt
  std::string engine = "slurm";
  FarmResources resources;

  [[nodiscard]] int frame_count() const { return frames.empty() ? 1 : static_cast<int>(frames.size()); }
  [[nodiscard]] int task_count() const { return frame_count() * parts; }
  [[nodiscard]] FarmTask task(int number) const;
  // The frame's number, or nothing for a plan without frames.
  [[nodiscard]] std::optional<int> frame(int index) const;

  // "frame-0012-part-003", or "part-003" without frames: what the files of a task are called.
  [[nodiscard]] std::string task_name(const FarmTask& task) const;
  [[nodiscard]] std::filesystem::path part_file(const FarmTask& task) const; // the finished part
  [[nodiscard]] std::filesystem::path
  unfinished_file(const FarmTask& task) const; // what its render writes; then renamed
  [[nodiscard]] std::filesystem::path checkpoint_file(const FarmTask& task) const; // of an unfinished one
  [[nodiscard]] std::filesystem::path task_record_file(const FarmTask& task) const;
  [[nodiscard]] std::filesystem::path stats_file(const FarmTask& task) const; // --stats of its render
  [[nodiscard]] std::filesystem::path frame_record_file(int index) const;
  [[nodiscard]] std::filesystem::path refusal_file() const; // there once the scene or the flags were refused
  [[nodiscard]] std::vector<std::filesystem::path> outputs_of(int index) const;
};

inline constexpr std::string_view kFramePattern = "frame-####"; // what the names of a frame's files begin with
// The run of # in the name replaced by the number, padded with zeros to the run's length, a minus before them.
[[nodiscard]] std::string with_frame_number(std::string_view name, int frame);

// DIR/plan.json. Writing makes the folders; fails (input_output), and (usage) where there is a plan already.
[[nodiscard]] Result<void> write_new_plan(const FarmPlan& plan);
// `folder` becomes absolute. Fails (input_output), also for a plan of another version.
[[nodiscard]] Result<FarmPlan> read_plan(const std::filesystem::path& folder);

} // namespace kindling
