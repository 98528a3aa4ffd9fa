// Queries in plain loops: the fallback for other processors, and the reference in tests.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD portable
#define KINDLING_SIMD_LEVEL 0

#include "accel/kdtree/kernels/structure_queries.h"

namespace kindling::accel::kd {

const Queries kPortableQueries = portable::make_queries();

} // namespace kindling::accel::kd
