// AVX2 queries for scenes split into a persistent and a transient tree.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD split_avx2
#define KINDLING_SIMD_LEVEL 2
#pragma GCC push_options
#pragma GCC target("avx2,fma,bmi,bmi2,lzcnt,popcnt")
#include "accel/kdtree/kernels/split_queries.h"
#pragma GCC pop_options

namespace kindling::accel::kd {

const Queries kAvx2SplitQueries = split_avx2::make_split_queries<kAvx2Queries>();

} // namespace kindling::accel::kd
