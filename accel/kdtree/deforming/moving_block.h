// Leaf blocks of deforming triangles: vertex positions at all keys that a time slice needs.
// leaf_format.h has the layout.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/deforming/swept.h"
#include "accel/kdtree/leaf_block.h"
#include "accel/kdtree/leaf_format.h"

#include <span>
#include <vector>

namespace kindling::accel::kd {

// Appends the blocks of a leaf, which must have at least one reference.
void append_moving_leaf(std::span<const Geometry> geometries, std::span<const LeafReference> references,
                        const TimeSlice& slice, std::vector<LeafUnit>& out);

} // namespace kindling::accel::kd
