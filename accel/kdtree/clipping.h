// Perfect splits: bounds of the part of a triangle that lies in a box.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/reference.h"

#include <ImathBox.h>
#include <ImathVec.h>

#include <array>
#include <span>

namespace kindling::accel::kd {

// Computes the bounds of the intersection of triangle and box in double precision, rounded outwards
// and cut to the box. Returns false if they do not meet; touching counts as meeting.
[[nodiscard]] bool clip_bounds(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min,
                               const Imath::V3f& box_max, Imath::V3f& bounds_min, Imath::V3f& bounds_max);

struct SplitReference {
  Reference left, right;
  bool in_left, in_right; // at least one is true; a part is valid only if its flag is
};

// Splits a reference with min[axis] < position < max[axis]: each part bounds the points within the
// reference's bounds on one side of the plane that are no farther from the triangle than its margin
// along each axis. If rounding leaves neither part, both are the bounds cut at the plane.
[[nodiscard]] SplitReference split_reference(const BuildMeshes& meshes, const Reference& reference, int axis,
                                             float position);

} // namespace kindling::accel::kd
