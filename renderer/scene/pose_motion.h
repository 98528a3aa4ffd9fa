// Adds the motion keys to a posed scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/scene/animated_nodes.h"
#include "renderer/scene/motion_probe.h"
#include "renderer/scene/pose.h"

namespace kindling {

// Fills the later_* members of `posed`, which must be posed at the opening, as must be the nodes.
// Meshes that deform over the shutter get world-space vertices at the opening as well. Returns
// false if more than `max_vertices` would be deformed over all keys. Parallel; deterministic.
// Changes the time of `nodes`.
[[nodiscard]] bool add_motion(const Scene& scene, const Shutter& shutter, GpuInstances gpu_instances,
                              uint64_t max_vertices, AnimatedNodes& nodes, PosedScene& posed);

} // namespace kindling
