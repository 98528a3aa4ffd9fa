// AVX2 queries for scenes with moving or deforming instances.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD moving_avx2
#define KINDLING_SIMD_LEVEL 2
#pragma GCC push_options
#pragma GCC target("avx2,fma,bmi,bmi2,lzcnt,popcnt")
#include "accel/kdtree/kernels/moving_queries.h"
#pragma GCC pop_options

namespace kindling::accel::kd {

const Queries kAvx2MovingQueries = moving_avx2::make_moving_queries<kAvx2Queries>();
const Queries kAvx2SplitMovingQueries = moving_avx2::make_moving_queries<kAvx2SplitQueries>();

} // namespace kindling::accel::kd
