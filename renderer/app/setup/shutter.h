// From the shutter of the options and that of the camera to times of the animations.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/base/result.h"
#include "renderer/scene/scene.h"

#include <optional>

namespace kindling::app {

// In times of the animations, around --time, 0 without it: as the flags say, else as the camera does that will be chosen.
// Nothing: no shutter. `root`: of choose_scene(). Fails (usage) if the camera is not there.
[[nodiscard]] Result<std::optional<Shutter>> choose_shutter(const Scene& scene, int root, const RenderOptions& options);

// The time at which things are taken that have one state for the whole image: the middle of the shutter.
[[nodiscard]] std::optional<double> time_of_image(const std::optional<Shutter>& shutter, const RenderOptions& options);

} // namespace kindling::app
