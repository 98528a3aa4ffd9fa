// Chooses the scene, the material variant, the camera and the image size that settings ask for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"
#include "renderer/session/image_settings.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Returns the index of the first entry of that name, else the number that the text is if it is an
// index; nothing if it is neither.
[[nodiscard]] std::optional<int> find_by_name_or_index(std::string_view text, const std::vector<std::string>& names);

// Returns an index into Scene::scenes; kNone, the default scene, for an empty name. Fails (usage)
// with a list of the scenes.
[[nodiscard]] Result<int> choose_scene(const Scene& scene, const std::string& name);

// Applies the materials of a variant and returns its index into Scene::variants; kNone for an empty
// name. Fails (usage) with a list of the variants.
[[nodiscard]] Result<int> show_variant(Scene& scene, const std::string& name);

// Returns the name that selects a posed camera: its node's, else its own, else an empty text.
[[nodiscard]] std::string camera_name(const Scene& scene, const PosedCamera& posed);
// Returns the names of all cameras of the posed scene, in the order of the tree: by
// ImageSettings::camera's index.
[[nodiscard]] std::vector<std::string> camera_names(const Scene& scene, const PosedScene& posed);

// Returns the index into PosedScene::cameras of the camera that is asked for, or of the first one.
// Nothing for an orbit or an own camera, and if the scene has none. Fails (usage) with a list of
// the cameras.
[[nodiscard]] Result<std::optional<int>> choose_camera_index(const Scene& scene, const PosedScene& posed,
                                                             const ImageSettings& image);

// Returns the camera that is asked for, or the first of the scene, with the field of view that is
// asked for. Nothing if the scene has none: one has to be fitted to the bounds of the World. Fails
// (usage) if there is no such camera, or if a field of view is asked of an orthographic one.
[[nodiscard]] Result<std::optional<PlacedCamera>> choose_camera(const Scene& scene, const PosedScene& posed,
                                                                const ImageSettings& image);
// Sets the field of view that is asked for, if any. Fails (usage) for an orthographic camera.
[[nodiscard]] Result<void> override_fov(SceneCamera& camera, const ImageSettings& image);

// Returns the size of the image in pixels, scale included. `camera` may be null: 16 to 9. Fails
// (usage) if a side is longer than kMaxImageSide, or if the crop lies outside.
[[nodiscard]] Result<V2i> choose_size(const SceneCamera* camera, const ImageSettings& image);

} // namespace kindling
