// AVX-512 (F, VL, BW, DQ) queries for every crossing of a ray.
// SPDX-License-Identifier: Apache-2.0
// GCC 12 warns of undefined operands inside its own intrinsics (GCC bug 105593).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

#include "accel/kdtree/kernels/includes.h"

#define KINDLING_SIMD all_hits_avx512
#define KINDLING_SIMD_LEVEL 512
#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512bw,avx512dq,avx2,fma,bmi,bmi2,lzcnt,popcnt")
#include "accel/kdtree/kernels/all_hits.h"
#pragma GCC pop_options

namespace kindling::accel::kd {

const AllHitsQueries kAvx512AllHits = {all_hits_avx512::all_hits, all_hits_avx512::all_hits_stream};

} // namespace kindling::accel::kd
