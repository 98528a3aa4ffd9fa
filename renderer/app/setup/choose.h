// What a person picks from a scene: one of its scenes, one of its cameras, the size of the image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling::app {

// The first entry of that name, else the entry of that number; nothing if there is neither.
[[nodiscard]] std::optional<int> find_by_name_or_index(std::string_view text, const std::vector<std::string>& names);

// Index into Scene::scenes, kNone for the default one. Fails (usage) with those that exist.
[[nodiscard]] Result<int> choose_scene(const Scene& scene, const std::string& name);

// Gives a loaded scene the materials of that variant: its index, kNone if none is asked for. Fails (usage) with those that exist.
[[nodiscard]] Result<int> show_variant(Scene& scene, const std::string& name);

// The name by which --camera finds a posed camera: its node's, else its own, else empty.
[[nodiscard]] std::string camera_name(const Scene& scene, const PosedCamera& posed);
// Each camera of the posed scene, in the order of the tree: the numbers that --camera takes.
[[nodiscard]] std::vector<std::string> camera_names(const Scene& scene, const PosedScene& posed);

// Index of the camera that is asked for among those of the posed scene, or of the first one. Nothing with --orbit, and if the scene has none.
// Fails (usage) if there is no such camera.
[[nodiscard]] Result<std::optional<int>> choose_camera_index(const Scene& scene, const PosedScene& posed,
                                                             const RenderOptions& options);

// The camera that is asked for, or the first of the scene. Nothing if the scene has none: one must be fitted to its
// bounds. Fails (usage) if there is no such camera, or a field of view is asked of an orthographic one.
[[nodiscard]] Result<std::optional<PlacedCamera>> choose_camera(const Scene& scene, const PosedScene& posed,
                                                                const RenderOptions& options);
// The field of view that is asked for, in a perspective camera; fails (usage) for an orthographic one.
[[nodiscard]] Result<void> override_fov(SceneCamera& camera, const RenderOptions& options);

// Pixels, with --size and --scale. `camera` may be null: 16 to 9. Fails (usage) if a crop or the pixel of a replay is
// outside.
[[nodiscard]] Result<V2i> choose_size(const SceneCamera* camera, const RenderOptions& options);

} // namespace kindling::app
