// Command lines of a farm's render and merge processes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_worker.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace kindling {

namespace {

// Flags of a render that its merge needs too, to make the images from the merged sums.
constexpr std::array<std::string_view, 5> kImageFlags = {"--view", "--exposure", "--ocio", "--png-bits",
                                                         "--jpeg-quality"};

// Returns the name of a task's file as --frames expects it, with #### in place of the frame's
// number.
std::string frame_pattern(const FarmTask& task, const std::filesystem::path& file) {
  if (!task.frame) return file.string();
  const size_t numbered = with_frame_number(kFramePattern, *task.frame).size();
  return (file.parent_path() / (std::string(kFramePattern) + file.filename().string().substr(numbered))).string();
}

} // namespace

std::vector<std::string> render_command(const FarmPlan& plan, const FarmTask& task, int threads) {
  std::vector<std::string> command{plan.binary.string(), "render", plan.scene.string()};
  command.insert(command.end(), plan.flags.begin(), plan.flags.end());
  if (task.frame) command.insert(command.end(), {"--frames", std::to_string(*task.frame)});
  command.insert(command.end(), {"--part", fmt::format("{}/{}", task.part, plan.parts), "--checkpoint",
                                 frame_pattern(task, plan.checkpoint_file(task)), "-o",
                                 frame_pattern(task, plan.unfinished_file(task)), "--stats",
                                 frame_pattern(task, plan.stats_file(task)), "--progress", "json"});
  if (threads > 0) command.insert(command.end(), {"--threads", std::to_string(threads)});
  return command;
}

std::vector<std::string> merge_command(const FarmPlan& plan, int frame_index) {
  std::vector<std::string> command{plan.binary.string(), "merge"};
  for (int part = 1; part <= plan.parts; ++part)
    command.push_back(plan.part_file({0, plan.frame(frame_index), part}).string());
  for (const std::filesystem::path& output : plan.outputs_of(frame_index))
    command.insert(command.end(), {"-o", output.string()});
  for (size_t i = 0; i < plan.flags.size(); ++i) {
    const std::string& flag = plan.flags[i];
    if (flag == "--exr-float") command.push_back(flag);
    if (std::find(kImageFlags.begin(), kImageFlags.end(), flag.substr(0, flag.find('='))) == kImageFlags.end())
      continue;
    command.push_back(flag);
    if (flag.find('=') == std::string::npos && i + 1 < plan.flags.size()) command.push_back(plan.flags[++i]);
  }
  return command;
}

} // namespace kindling
