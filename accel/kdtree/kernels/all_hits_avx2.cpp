// AVX2 queries for every crossing of a ray.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD all_hits_avx2
#define KINDLING_SIMD_LEVEL 2
#pragma GCC push_options
#pragma GCC target("avx2,fma,bmi,bmi2,lzcnt,popcnt")
#include "accel/kdtree/kernels/all_hits.h"
#pragma GCC pop_options

namespace kindling::accel::kd {

const AllHitsQueries kAvx2AllHits = {all_hits_avx2::all_hits, all_hits_avx2::all_hits_stream};

} // namespace kindling::accel::kd
