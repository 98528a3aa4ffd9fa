// Converts KHR_lights_punctual and EXT_lights_ies to lights of the world.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/light_set.h"
#include "renderer/scene/pose.h"

#include <vector>

namespace kindling {

// Appends to the points, spots, profiled and directional lights of `input`.
void add_punctual_lights(const Scene& scene, const std::vector<PosedLight>& posed, LightSetInput& input);

} // namespace kindling
