// Names and options of one frame of an animation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"

#include <filesystem>

namespace kindling::app {

// How many groups of '#' stand in a name.
[[nodiscard]] int count_frame_groups(const std::filesystem::path& name);
// The name with the number in place of its group of '#': digits padded with zeros to as many, a minus before them ("a_####.png": a_0007.png,
// a_-0007.png, a_12345.png).
[[nodiscard]] std::filesystem::path name_of_frame(const std::filesystem::path& pattern, int frame);

// The options of a single render that makes this frame: the moment is --time (0 without it) + frame / fps, names have the number.
[[nodiscard]] RenderOptions options_of_frame(const RenderOptions& options, int frame);

} // namespace kindling::app
