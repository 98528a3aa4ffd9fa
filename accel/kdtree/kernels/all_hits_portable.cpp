// Plain-loop queries for every crossing of a ray.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD all_hits_portable
#define KINDLING_SIMD_LEVEL 0

#include "accel/kdtree/kernels/all_hits.h"

namespace kindling::accel::kd {

const AllHitsQueries kPortableAllHits = {all_hits_portable::all_hits, all_hits_portable::all_hits_stream};

} // namespace kindling::accel::kd
