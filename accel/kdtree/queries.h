// The queries of a structure, compiled once for each SIMD target; which one serves is decided at run time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/structure.h"
#include "accel/simd_target.h"

#include <cstdint>
#include <span>

namespace kindling::accel::kd {

// Semantics as in Accelerator. All targets give the same answers bit for bit.
struct Queries {
  Hit (*intersect)(const Structure&, const Ray&);
  bool (*occluded)(const Structure&, const Ray&);
  void (*intersect_stream)(const Structure&, std::span<const Ray>, std::span<Hit>);
  void (*occluded_stream)(const Structure&, std::span<const Ray>, std::span<uint8_t>);
  void (*intersect_coherent)(const Structure&, std::span<const Ray>, std::span<Hit>);
  void (*occluded_coherent)(const Structure&, std::span<const Ray>, std::span<uint8_t>);
};

// `target` must be one that this processor runs; see simd_target.h. `moving`: for structures in which something moves.
[[nodiscard]] const Queries& queries_for(SimdTarget target, bool moving);

// One definition in each of kernels/portable.cpp, kernels/avx2.cpp and kernels/avx512.cpp.
extern const Queries kPortableQueries, kPortableMovingQueries;
#if defined(__x86_64__)
extern const Queries kAvx2Queries, kAvx2MovingQueries, kAvx512Queries, kAvx512MovingQueries;
#endif

} // namespace kindling::accel::kd
