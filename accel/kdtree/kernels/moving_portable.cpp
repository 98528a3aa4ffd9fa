// Plain-loop queries for scenes with moving or deforming instances.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD moving_portable
#define KINDLING_SIMD_LEVEL 0

#include "accel/kdtree/kernels/moving_queries.h"

namespace kindling::accel::kd {

const Queries kPortableMovingQueries = moving_portable::make_moving_queries<kPortableQueries>();
const Queries kPortableSplitMovingQueries = moving_portable::make_moving_queries<kPortableSplitQueries>();

} // namespace kindling::accel::kd
