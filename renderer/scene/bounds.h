// The world box of a posed scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/pose.h"

namespace kindling {

// The smallest axis-aligned box around all vertices of visible triangles, in world space; empty if there are none.
// Non-finite positions do not count. Where instances multiply to more than 2^27 triangle corners, rotated instances
// count with the box of their mesh's box, which may be larger than needed. Parallel; deterministic.
[[nodiscard]] Box3f world_bounds(const Scene& scene, const PosedScene& posed);

} // namespace kindling
