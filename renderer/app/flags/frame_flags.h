// Flags of the frames of an animation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/frame_options.h"
#include "renderer/base/result.h"

#include <string_view>
#include <vector>

namespace kindling::app {

struct RenderOptions;
class FlagSet;

// "7", "1-10", "1-10x3" (1, 4, 7, 10), "-5--1", and lists of them, "1-10,20"; a frame that is named again does not count again. Fails
// (usage).
[[nodiscard]] Result<std::vector<int>> parse_frames(std::string_view text);

void add_frame_flags(FlagSet& flags, RenderOptions& options);
// What no flag can judge alone; fails (usage). Frames need frames per second: without --fps 24.
[[nodiscard]] Result<void> check_frame_flags(const FlagSet& flags, RenderOptions& options);

} // namespace kindling::app
