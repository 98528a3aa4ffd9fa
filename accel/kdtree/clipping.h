// Perfect splits: the bounds of the part of a triangle that lies in a box.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ImathBox.h>
#include <ImathVec.h>

#include <array>

namespace kindling::accel::kd {

// Bounds of the intersection of triangle and box, computed in double, rounded outwards, and cut to the box. False if they
// do not meet; touching counts as meeting.
[[nodiscard]] bool clip_bounds(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min,
                               const Imath::V3f& box_max, Imath::V3f& bounds_min, Imath::V3f& bounds_max);

} // namespace kindling::accel::kd
