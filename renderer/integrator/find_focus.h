// Autofocus: how far away is what a camera sees at one place of its image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/world/world.h"

#include <optional>

namespace kindling {

// Depth along the axis, in meters and above 0, of the first surface through this film position when the shutter opens; nothing if there is none.
// ThinWalls and what covers less than half are looked through. `camera` must have no lens yet.
[[nodiscard]] std::optional<float> find_focus_distance(const World& world, const Camera& camera, const V2f& film_px);

} // namespace kindling
