// Finds which two-sided triangles bound a small closed body: their inner sides light nothing that a path would visit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/light_set.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

enum class OuterSide : uint8_t { both, front, back };

// The side of each triangle that looks out. Of triangles that hang together by equal vertices a body is closed if their
// area vectors cancel, and encloses some volume; small if it is less than a quarter of the scene's radius in size, so
// that a glowing sky or room keeps both sides. `candidate[i]` false: not asked, `both`.
// Good for choosing where to sample, not proof enough for leaving a side out.
[[nodiscard]] std::vector<OuterSide> find_outer_sides(std::span<const EmissiveTriangle> triangles,
                                                      const std::vector<bool>& candidate, float scene_radius_m);

} // namespace kindling
