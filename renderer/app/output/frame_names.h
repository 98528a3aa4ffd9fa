// File names and options of one frame of an animation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"

#include <filesystem>

namespace kindling::app {

// The number of groups of '#' in a name.
[[nodiscard]] int count_frame_groups(const std::filesystem::path& name);
// Replaces the group of '#' of a name by the frame number, padded with zeros to the length of the
// group: "a_####.png" gives a_0007.png, a_-0007.png, a_12345.png.
[[nodiscard]] std::filesystem::path name_of_frame(const std::filesystem::path& pattern, int frame);

// The options of a single render of this frame: its time is --time (0 if unset) + frame / fps, or
// its turn is that of the turntable; its file names have the number.
[[nodiscard]] RenderOptions options_of_frame(const RenderOptions& options, int frame);

} // namespace kindling::app
