// What a ray's way through a kd-tree costs, counted by a plain walk.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/structure.h"

namespace kindling::accel::kd {

// Visits what the single query visits, in its order (kernels/traversal.h), one lane after the other; asks the hit filter alike.
// Nodes are wide nodes, those of the instance level among them; triangles are those of the blocks that were tested, in which
// the widest kernels test all at once. `any_hit`: ends at the first.
[[nodiscard]] TraversalCost traversal_cost(const Structure& structure, const Ray& ray, bool any_hit);

} // namespace kindling::accel::kd
