// How long the shutter is open: flags, and what they mean beside the camera's own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/scene/scene.h"

#include <optional>

namespace kindling::app {

struct RenderOptions;
class FlagSet;

// Relative to --time. At most one of the two is set.
struct ShutterOptions {
  std::optional<Shutter> interval;
  // Of a rotary shutter: the part of each frame for which it is open, from the time of the picture on.
  std::optional<double> angle_deg;
  std::optional<double> frames_per_s;
};

void add_shutter_flags(FlagSet& flags, RenderOptions& options);
// What no flag can judge alone; fails (usage).
[[nodiscard]] Result<void> check_shutter_flags(const FlagSet& flags, const RenderOptions& options);

// In times of the animations, around --time, 0 without it: as the flags say, else as the camera does that will be chosen.
// Nothing: no shutter. `root`: of choose_scene(). Fails (usage) if the camera is not there.
[[nodiscard]] Result<std::optional<Shutter>> choose_shutter(const Scene& scene, int root, const RenderOptions& options);

// The time at which things are taken that have one state for the whole picture: the middle of the shutter.
[[nodiscard]] std::optional<double> time_of_picture(const std::optional<Shutter>& shutter,
                                                    const RenderOptions& options);

} // namespace kindling::app
