// The surface that a camera sees at a position of its image, and autofocus by it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/world/world.h"

#include <optional>

namespace kindling {

struct FoundSurface {
  accel::Hit hit;
  SurfacePoint surface;
  float depth_m = 0.0f; // along the camera's axis
};

// Returns the first surface at this film position when the shutter opens, through the center of the
// lens, or nothing if there is none. Surfaces with a coverage below one half are ignored; `flags`
// are added to those of its ray (surface_point.h).
[[nodiscard]] std::optional<FoundSurface> find_surface(const World& world, const Camera& camera, const V2f& film_px,
                                                       uint32_t flags = 0);

// Returns the depth along the camera's axis, in meters and above 0, of the first surface at this
// film position when the shutter opens, or nothing if there is none. Thin walls and surfaces with a
// coverage below one half are ignored. `camera` must not have a lens.
[[nodiscard]] std::optional<float> find_focus_distance(const World& world, const Camera& camera, const V2f& film_px);

} // namespace kindling
