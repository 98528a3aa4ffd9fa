// Light groups of a file's extras, as a World keeps them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/pose.h"
#include "renderer/scene/scene.h"
#include "renderer/world/world.h"

namespace kindling {

// Returns the groups of nodes and materials. A node's group is that of its nearest ancestor, itself
// included.
[[nodiscard]] FileLightGroups find_file_light_groups(const Scene& scene);
// Adds those of lights: a light's group is that of its node, else its own.
void add_groups_of_lights(const Scene& scene, const PosedScene& posed, const LightSet& lights, FileLightGroups& groups);

} // namespace kindling
