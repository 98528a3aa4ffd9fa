// Shadow catchers by the names of nodes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/facade/render_scene.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kindling {

// Returns a flag for each of Scene::nodes: 1 for the named ones and all below them. Empty without
// names, else RenderScene::names must be set. Fails (usage) with the nearest names if there is no
// such node.
[[nodiscard]] Result<std::vector<uint8_t>> choose_catchers(const RenderScene& scene,
                                                           const std::vector<std::string>& names);

} // namespace kindling
