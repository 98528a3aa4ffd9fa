// Finds two-sided emissive triangles that bound a small closed body.
// Paths never visit the inner sides of such bodies, so light sampling can avoid them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/light_set.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

enum class OuterSide : uint8_t { both, front, back };

// Returns the outward-facing side of each triangle. Triangles connected by equal vertices form a
// body. A body is closed if its area vectors cancel and it encloses some volume; it is small if its
// size is less than a quarter of the scene's radius, so that a glowing sky or room keeps both
// sides. Triangles with `candidate[i]` false get `both`. The heuristic is good enough to steer
// sampling, but not to ignore a side.
[[nodiscard]] std::vector<OuterSide> find_outer_sides(std::span<const EmissiveTriangle> triangles,
                                                      const std::vector<bool>& candidate, float scene_radius_m);

} // namespace kindling
