// Detects a `--frames` range in which nothing moves, so that every frame would be the same image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/scene/scene.h"

#include <string>

namespace kindling::app {

// Returns one line that says that all frames of options.frames are equal and why, or an empty
// string if they may differ or if there is only one. `root`: of choose_scene().
[[nodiscard]] std::string equal_frames_warning(const Scene& scene, int root, const RenderOptions& options);

} // namespace kindling::app
