// The oracle of split references: exact bounds of the part of a triangle that lies in a box.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ImathVec.h>

#include <array>

namespace kindling::accel::testing {

// Computes the bounds of the intersection of triangle and box in double precision, rounded outwards
// to float and cut to the box. Returns false if they do not meet; touching counts as meeting.
[[nodiscard]] bool clip_bounds(const std::array<Imath::V3f, 3>& triangle, const Imath::V3f& box_min,
                               const Imath::V3f& box_max, Imath::V3f& bounds_min, Imath::V3f& bounds_max);

} // namespace kindling::accel::testing
