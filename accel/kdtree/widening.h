// Relative errors of distances in a traversal, by which the intervals of cells are widened.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/triangle.h"

namespace kindling::accel::kd {

// Bound of the relative errors of two distances: kDistanceTolerance, and the rounding of the
// distances to planes.
inline constexpr float kRelativeSlack = 2.0f * (kDistanceTolerance + 0x1p-22f);
inline constexpr float kWiden = 1.0f + kRelativeSlack, kBefore = 1.0f - kRelativeSlack;
// Rays are followed this factor beyond their end or nearest hit.
inline constexpr float kBeyond = kWiden * kWiden;

} // namespace kindling::accel::kd
