// What moves in a posed scene over the shutter.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/animated_nodes.h"
#include "renderer/scene/motion_probe.h"
#include "renderer/scene/pose.h"

namespace kindling {

// Fills what is called later_* in `posed`, which is as it is at the opening, as are the nodes. Meshes that deform over the shutter get
// their vertices at the opening as well, in world space. At most `max_vertices` may be deformed, over all keys: false if that is not
// enough. Parallel; deterministic. Leaves the nodes at some other time.
[[nodiscard]] bool add_motion(const Scene& scene, const Shutter& shutter, GpuInstances gpu_instances,
                              uint64_t max_vertices, AnimatedNodes& nodes, PosedScene& posed);

} // namespace kindling
