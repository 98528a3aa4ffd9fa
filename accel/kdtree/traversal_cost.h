// Counts the nodes, leaves and triangles that a ray visits, by a scalar traversal.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/structure.h"

namespace kindling::accel::kd {

// Visits what the single query visits, in the same order (kernels/traversal.h, box_walk.h), lane by
// lane, and
// calls the hit filter alike. Nodes are wide nodes, including those of the instance level.
// Triangles are those of the tested blocks, which the widest kernels test all at once. `any_hit`:
// ends at the first hit.
[[nodiscard]] TraversalCost traversal_cost(const Structure& structure, const Ray& ray, bool any_hit);

} // namespace kindling::accel::kd
