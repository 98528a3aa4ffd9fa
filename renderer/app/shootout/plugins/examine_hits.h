// Checks whether hits can be hits at all: ids, numbers, and the point where they lie.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"

#include <string>

namespace kindling::app {

// Returns what makes a hit of this ray none, as "triangle 90 of mesh 2, which has 36"; empty for
// misses and for hits with ids of the geometry and finite numbers in their ranges.
[[nodiscard]] std::string why_no_hit(const accel::BuildInput& geometry, const accel::Ray& ray, const accel::Hit& hit);

// Returns true if the point at u and v of the triangle is that of the ray at t, to a thousandth of
// the distance and the coordinates. why_no_hit() must be empty, and nothing may move.
[[nodiscard]] bool lies_on_its_triangle(const accel::BuildInput& geometry, const accel::Ray& ray,
                                        const accel::Hit& hit);

} // namespace kindling::app
