// Queries for AVX2.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD avx2
#define KINDLING_SIMD_LEVEL 2
#pragma GCC push_options
#pragma GCC target("avx2,fma,bmi,bmi2,lzcnt,popcnt")
#include "accel/kdtree/kernels/structure_queries.h"
#pragma GCC pop_options

namespace kindling::accel::kd {

const Queries kAvx2Queries = avx2::make_queries();

} // namespace kindling::accel::kd
