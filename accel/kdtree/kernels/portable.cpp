// The queries in plain loops, for processors without the instruction sets below and to test those against.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD portable
#define KINDLING_SIMD_LEVEL 0

#include "accel/kdtree/kernels/moving_queries.h"

namespace kindling::accel::kd {

const Queries kPortableQueries = portable::make_queries(), kPortableMovingQueries = portable::make_moving_queries();

} // namespace kindling::accel::kd
