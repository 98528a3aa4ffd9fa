// The queries of structures whose world is divided, in plain loops, for processors without the instruction sets below and to test those against.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD divided_portable
#define KINDLING_SIMD_LEVEL 0

#include "accel/kdtree/kernels/divided_queries.h"

namespace kindling::accel::kd {

const Queries kPortableDividedQueries = divided_portable::make_divided_queries<kPortableQueries>();

} // namespace kindling::accel::kd
