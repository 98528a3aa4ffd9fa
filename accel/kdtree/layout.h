// Converts a binary tree to finished nodes and leaf blocks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/binary_tree.h"
#include "accel/kdtree/build/build.h"
#include "accel/kdtree/deforming/swept.h"
#include "accel/kdtree/node.h"

#include <vector>

namespace kindling::accel::kd {

// Throws std::bad_alloc if memory runs out, or if the tree exceeds the range of a ChildWord (16 GiB
// of leaves). `slice`: the slice of the shutter for a deforming tree, else null. For such a
// tree the caller sets clip_bounds and clip_bounds_at_end. `monitor`: null, or polled; after a
// cancellation the tree is incomplete.
[[nodiscard]] Tree lay_out(BinaryTree binary, std::vector<Geometry> geometries, const TimeSlice* slice = nullptr,
                           const BuildMonitor* monitor = nullptr);

} // namespace kindling::accel::kd
