// The flags that choose frames of an animation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/frame_options.h"
#include "renderer/base/result.h"

#include <filesystem>
#include <string_view>
#include <vector>

namespace kindling::app {

struct RenderOptions;
class FlagSet;

// Parses "7", "1-10", "1-10x3" (1, 4, 7, 10), "-5--1", and lists of them, "1-10,20". Each frame is
// returned once, in the order in which it is first named. Fails (usage).
[[nodiscard]] Result<std::vector<int>> parse_frames(std::string_view text);

// Fails (usage) unless a name has one group of # for the frame number.
[[nodiscard]] Result<void> check_frame_name(std::string_view flag, const std::filesystem::path& name);

void add_frame_flags(FlagSet& flags, RenderOptions& options);
// Checks combinations of flags and sets the frames per second if --fps does not; fails (usage).
[[nodiscard]] Result<void> check_frame_flags(const FlagSet& flags, RenderOptions& options);

} // namespace kindling::app
