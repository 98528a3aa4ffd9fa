// Plain-loop queries for scenes split into a persistent and a transient tree.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD split_portable
#define KINDLING_SIMD_LEVEL 0

#include "accel/kdtree/kernels/split_queries.h"

namespace kindling::accel::kd {

const Queries kPortableSplitQueries = split_portable::make_split_queries<kPortableQueries>();

} // namespace kindling::accel::kd
