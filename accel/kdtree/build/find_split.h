// The search for the plane that divides a node.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/reference_blocks.h"
#include "accel/kdtree/build/split.h"

#include <ImathBox.h>

#include <optional>
#include <span>

namespace kindling::accel::kd {

// Returns nullopt if a leaf is cheaper than the best split.
[[nodiscard]] std::optional<Split> find_split(const Config& config, const CostModel& model, const Imath::Box3f& box,
                                              std::span<const Reference> references, SplitScratch& scratch);

// Likewise, of more references than Config::refine_below and Config::exact_below.
[[nodiscard]] std::optional<Split> find_split(const Config& config, const CostModel& model, const Imath::Box3f& box,
                                              const ReferenceBlocks& references);

} // namespace kindling::accel::kd
