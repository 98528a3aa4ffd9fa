// Frames of an animation: which ones, when they are, and what their files are called.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

struct RenderOptions;
class FlagSet;

inline constexpr double kDefaultFramesPerSecond = 24.0;
inline constexpr int kLastFrame = 9'999'999; // and the first is its negative
inline constexpr size_t kMostFrames = 1'000'000;

struct FrameOptions {
  std::vector<int>
      numbers; // each once, in the order in which they are rendered; empty: one picture, its names taken literally
  bool force = false; // render those too whose files are there
};

// "7", "1-10", "1-10x3" (1, 4, 7, 10), "-5--1", and lists of them, "1-10,20"; a frame that is named again does not count again. Fails
// (usage).
[[nodiscard]] Result<std::vector<int>> parse_frames(std::string_view text);

void add_frame_flags(FlagSet& flags, RenderOptions& options);
// What no flag can judge alone; fails (usage). Frames need frames per second: without --fps 24.
[[nodiscard]] Result<void> check_frame_flags(const FlagSet& flags, RenderOptions& options);

// How many groups of '#' stand in a name.
[[nodiscard]] int count_frame_groups(const std::filesystem::path& name);
// The name with the number in place of its group of '#': digits padded with zeros to as many, a minus before them ("a_####.png": a_0007.png,
// a_-0007.png, a_12345.png).
[[nodiscard]] std::filesystem::path name_of_frame(const std::filesystem::path& pattern, int frame);

// The options of a single render that makes this frame: the moment is --time (0 without it) + frame / fps, names have the number.
[[nodiscard]] RenderOptions options_of_frame(const RenderOptions& options, int frame);

} // namespace kindling::app
