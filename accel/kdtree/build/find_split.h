// The search for the plane that divides a node.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/node_references.h"
#include "accel/kdtree/build/split.h"

#include <ImathBox.h>

#include <optional>

namespace kindling::accel::kd {

// Returns nullopt if a leaf is cheaper than the best split.
[[nodiscard]] std::optional<Split> find_split(const Config& config, const CostModel& model, const Imath::Box3f& box,
                                              const NodeReferences& references, SplitScratch& scratch);

} // namespace kindling::accel::kd
