// The queries of structures in which something moves, in plain loops, for processors without the instruction sets below and to test those against.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD moving_portable
#define KINDLING_SIMD_LEVEL 0

#include "accel/kdtree/kernels/moving_queries.h"

namespace kindling::accel::kd {

const Queries kPortableMovingQueries = moving_portable::make_moving_queries<kPortableQueries>();
const Queries kPortableSplitMovingQueries = moving_portable::make_moving_queries<kPortableSplitQueries>();

} // namespace kindling::accel::kd
