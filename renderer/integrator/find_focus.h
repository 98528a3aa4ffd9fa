// Autofocus: the depth of the surface that a camera sees at a position of its image.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/world/world.h"

#include <optional>

namespace kindling {

// Returns the depth along the camera's axis, in meters and above 0, of the first surface at this
// film position when the shutter opens, or nothing if there is none. Thin walls and surfaces with a
// coverage below one half are ignored. `camera` must not have a lens.
[[nodiscard]] std::optional<float> find_focus_distance(const World& world, const Camera& camera, const V2f& film_px);

} // namespace kindling
