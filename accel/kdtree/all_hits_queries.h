// Every crossing of one ray or many, by the queries of an instruction set.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/queries.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling::accel::kd {

// See Accelerator::all_hits().
void all_hits(const AllHitsQueries& queries, const Structure& structure, const Ray& ray, size_t limit,
              std::vector<Crossing>& crossings);
// See kdtree_all_hits().
void all_hits(const AllHitsQueries& queries, const Structure& structure, std::span<const Ray> rays, size_t limit,
              std::vector<Crossing>& crossings, std::span<uint32_t> counts);

} // namespace kindling::accel::kd
