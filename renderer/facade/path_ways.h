// The vertices of a replayed path, as the image shows them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/camera/camera.h"
#include "renderer/integrator/integrator.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace kindling {

// Event of a path where a way begins.
enum class PathStep : uint8_t { camera, diffuse, glossy, transmission, straight, medium };
[[nodiscard]] std::string_view path_step_name(PathStep step);

// The way to a vertex of a trace from the one before it.
struct PathWay {
  PathStep step = PathStep::camera;
  // From and to, in fractions of the image's width and height from its upper left corner, possibly
  // outside. Unset for the first vertex, and if all of the way is behind the camera. What is behind
  // the camera is cut off.
  std::optional<std::array<V2f, 2>> seen;
};

// Returns a way for each vertex. A vertex that has escaped is far outside of the bounds; there is
// no way to kJoinedEvent.
[[nodiscard]] std::vector<PathWay> find_path_ways(const Camera& camera, const PathTrace& trace, const Box3f& bounds);

} // namespace kindling
