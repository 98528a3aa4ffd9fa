// World-space bounds of a posed scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/pose.h"

namespace kindling {

// Returns the smallest axis-aligned box around all vertices of visible triangles, in world space;
// empty if there are none. Non-finite positions are ignored. If instancing yields more than 2^27
// triangle corners, rotated instances contribute the transformed box of their mesh, which may be
// larger than needed. Parallel; deterministic.
[[nodiscard]] Box3f world_bounds(const Scene& scene, const PosedScene& posed);

} // namespace kindling
