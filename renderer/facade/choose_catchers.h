// Shadow catchers by the names of nodes, and those that the file marks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/facade/render_scene.h"
#include "renderer/integrator/shadow_catchers.h"
#include "renderer/session/image_settings.h"

#include <optional>

namespace kindling {

// Returns flags for ImageSettings::shadow_catchers and all below them, and with
// ImageSettings::shadow_catchers_of_file for the nodes, all below them, and the materials that the
// file marks. Nothing if the image has no shadow catchers. For names RenderScene::names must be
// set. Fails (usage) with the nearest names if there is no such node, and if the file is to name
// catchers and marks none.
[[nodiscard]] Result<std::optional<CatcherFlags>> choose_catchers(const RenderScene& scene, const ImageSettings& image);

} // namespace kindling
