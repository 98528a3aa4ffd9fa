// How many references the leaves of a tree hold: for reports.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/node.h"

#include <cstddef>
#include <vector>

namespace kindling::accel::kd {

// Adds the leaves of n references to sizes[n], which grows as needed. Linear in the number of leaf blocks.
void count_leaf_sizes(const Tree& tree, std::vector<size_t>& sizes);

} // namespace kindling::accel::kd
