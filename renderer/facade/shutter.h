// Resolves the shutter of the settings, or of the camera, to times of the animations.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/scene/scene.h"
#include "renderer/session/image_settings.h"

#include <optional>

namespace kindling {

// Returns the shutter in times of the animations, around ImageSettings::time_s (0 if unset): that
// of the settings, else that of the camera that will be chosen. Nothing if neither has one. `root`:
// from choose_scene(). Fails (usage) if there is no such camera.
[[nodiscard]] Result<std::optional<Shutter>> choose_shutter(const Scene& scene, int root, const ImageSettings& image);

// Returns the time of everything that has one state for the whole image: the middle of the shutter,
// else ImageSettings::time_s.
[[nodiscard]] std::optional<double> time_of_image(const std::optional<Shutter>& shutter, const ImageSettings& image);

} // namespace kindling
