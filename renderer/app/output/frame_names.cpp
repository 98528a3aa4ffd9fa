// Puts frame numbers into file names.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/frame_names.h"

#include "renderer/app/output/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>

namespace kindling::app {

namespace {

// Begin and end of the group of '#' in a name; begin is npos without one.
std::pair<size_t, size_t> find_group(const std::string& name) {
  const size_t begin = name.find('#');
  return {begin, std::min(name.find_first_not_of('#', begin), name.size())};
}

} // namespace

int count_frame_groups(const std::filesystem::path& name) {
  const std::string& text = name.native();
  int groups = 0;
  for (size_t i = 0; i < text.size(); ++i) groups += text[i] == '#' && (i == 0 || text[i - 1] != '#') ? 1 : 0;
  return groups;
}

std::filesystem::path name_of_frame(const std::filesystem::path& pattern, int frame) {
  std::string name = pattern.string();
  const auto [begin, end] = find_group(name);
  if (begin == std::string::npos) return pattern;
  const std::string number = fmt::format("{}{:0{}}", frame < 0 ? "-" : "", std::abs(frame), end - begin);
  return name.replace(begin, end - begin, number);
}

RenderOptions options_of_frame(const RenderOptions& options, int frame) {
  RenderOptions own = options;
  own.frames = {};
  own.frames.video_only = options.frames.video_only;
  own.checkpoint.file = name_of_frame(options.checkpoint.file, frame);
  own.checkpoint.replace = options.frames.force;
  for (const std::string& word : {std::string("--frames"), fmt::format("{}", frame)}) own.arguments.push_back(word);
  if (options.frames.turntable) own.turn->angle_deg = 360.0 * frame / *options.frames.turntable;
  if (!options.frames.turntable || options.frames.turntable_animated)
    own.time_s = options.time_s.value_or(0.0) + frame / options.shutter.frames_per_s.value_or(kDefaultFramesPerSecond);
  if (own.outputs.empty() && !options.frames.video_only) own.outputs = {default_output(options)};
  for (std::filesystem::path& output : own.outputs) output = name_of_frame(output, frame);
  own.stats_file = name_of_frame(options.stats_file, frame);
  return own;
}

} // namespace kindling::app
