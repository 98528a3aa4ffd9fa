// A histogram of leaf sizes of a tree, for reports.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/node.h"

#include <cstddef>
#include <vector>

namespace kindling::accel::kd {

// Adds the number of leaves with n references to sizes[n], which grows as needed. Linear in the
// number of leaf blocks.
void count_leaf_sizes(const Tree& tree, std::vector<size_t>& sizes);

} // namespace kindling::accel::kd
