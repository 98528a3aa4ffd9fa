// World bounds of instances, by their vertices or by boxes of parts of their trees.
//
// The box around a turned box is up to 1.7 times as large along each axis as that around what is in
// it. A ray visits fewer instances and nodes above them if the box is that around turned parts.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/node.h"

#include <ImathBox.h>
#include <ImathMatrix.h>

#include <cstddef>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// Returns at most `limit` boxes; of what is transformed with them, everything in a static tree that
// a ray can hit is in their common bounds. They are those of the vertices, if these are few, or of
// the tree's uppermost nodes.
[[nodiscard]] std::vector<Imath::Box3f> parts_of(const Tree& tree, size_t limit);

// Returns how many boxes of a tree are worth the time if there are so many instances.
[[nodiscard]] size_t parts_for(size_t instances);

// Returns bounds at all times of boxes that move with a matrix interpolated between keys, a few
// rounding errors larger than exact.
[[nodiscard]] Imath::Box3f transform_bounds(std::span<const Imath::M44f> keys, const std::vector<Imath::Box3f>& boxes);

// Returns rounding_growth() over the shutter: twice that at the keys and halfway between them.
[[nodiscard]] float growth_of(std::span<const Imath::M44f> keys);

} // namespace kindling::accel::kd
