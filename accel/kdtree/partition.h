// Deals the references of a node out to its two children, clipping those that lie in both.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/reference.h"
#include "accel/kdtree/split.h"

#include <span>
#include <vector>

namespace kindling::accel::kd {

struct Halves {
  std::vector<Reference> left, right;
};

// Keeps the order of the references. Parallel for many; the result does not depend on the number of threads.
[[nodiscard]] Halves partition(std::span<const Geometry> geometries, std::span<const Reference> references,
                               const Split& split);

} // namespace kindling::accel::kd
