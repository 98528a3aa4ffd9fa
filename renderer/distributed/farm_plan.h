// A farm's plan: one scene, its frames in parts, and how to render and merge them.
//
// The plan, all records and all results are in one folder that all machines share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Resources of each task; empty or 0: the engine's default.
struct FarmResources {
  std::string partition;
  int threads_per_part = 0; // 0: a part has a machine to itself
  std::string memory;       // in Slurm's notation: "4G"
  std::string time;         // maximum duration of an attempt, in Slurm's notation: "2:00:00"
};

// A task renders one part of one frame.
struct FarmTask {
  int number = 0;           // from 0, frame by frame
  std::optional<int> frame; // unset if the plan has no frames
  int part = 1;             // from 1
};

struct FarmPlan {
  std::string program;                  // version of the program that made the plan
  std::filesystem::path binary;         // absolute; the same on all machines
  std::filesystem::path folder;         // absolute; the farm's own
  std::filesystem::path scene;          // absolute
  std::filesystem::path working_folder; // absolute; base of relative paths in `flags`
  std::vector<std::string> flags;       // for `render`, without those that the farm sets itself
  std::vector<int> frames;              // empty: one image, no animation
  int parts = 1;
  std::vector<std::filesystem::path> outputs; // absolute; with frames, #### stands for the frame's number
  int retries = 2;                            // per part, after its first attempt
  std::string engine = "slurm";
  FarmResources resources;

  [[nodiscard]] int frame_count() const { return frames.empty() ? 1 : static_cast<int>(frames.size()); }
  [[nodiscard]] int task_count() const { return frame_count() * parts; }
  [[nodiscard]] FarmTask task(int number) const;
  // Returns the number of the index-th frame, or nothing for a plan without frames.
  [[nodiscard]] std::optional<int> frame(int index) const;

  // Returns the stem of a task's file names: "frame-0012-part-003", or "part-003" without frames.
  [[nodiscard]] std::string task_name(const FarmTask& task) const;
  // A render writes unfinished_file(), which is renamed to part_file() in the end.
  [[nodiscard]] std::filesystem::path part_file(const FarmTask& task) const;
  [[nodiscard]] std::filesystem::path unfinished_file(const FarmTask& task) const;
  [[nodiscard]] std::filesystem::path checkpoint_file(const FarmTask& task) const;
  [[nodiscard]] std::filesystem::path task_record_file(const FarmTask& task) const;
  [[nodiscard]] std::filesystem::path stats_file(const FarmTask& task) const; // --stats of its render
  [[nodiscard]] std::filesystem::path frame_record_file(int index) const;
  [[nodiscard]] std::filesystem::path refusal_file() const; // exists once the scene or the flags were refused
  [[nodiscard]] std::vector<std::filesystem::path> outputs_of(int index) const;
};

inline constexpr std::string_view kFramePattern = "frame-####"; // prefix of the names of a frame's files
// Replaces the run of # in the name by the number, padded with zeros to the run's length, after a
// minus if negative.
[[nodiscard]] std::string with_frame_number(std::string_view name, int frame);

// Creates the farm's folders and writes DIR/plan.json. Fails (usage) if there is a plan already,
// else (input_output).
[[nodiscard]] Result<void> write_new_plan(const FarmPlan& plan);
// Reads DIR/plan.json; FarmPlan::folder is absolute. Fails (input_output), also for a plan of
// another version.
[[nodiscard]] Result<FarmPlan> read_plan(const std::filesystem::path& folder);

} // namespace kindling
