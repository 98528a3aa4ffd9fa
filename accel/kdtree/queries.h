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

// For which structures: those in which something moves, and those whose world is divided.
struct QueryNeeds {
  bool moving = false, divided = false;
};
// `target` must be one that this processor runs; see simd_target.h.
[[nodiscard]] const Queries& queries_for(SimdTarget target, QueryNeeds needs);

// Definitions in kernels/portable.cpp, kernels/split_portable.cpp and kernels/moving_portable.cpp, and likewise for the others.
extern const Queries kPortableQueries, kPortableSplitQueries, kPortableMovingQueries, kPortableSplitMovingQueries;
#if defined(__x86_64__)
extern const Queries kAvx2Queries, kAvx2SplitQueries, kAvx2MovingQueries, kAvx2SplitMovingQueries;
extern const Queries kAvx512Queries, kAvx512SplitQueries, kAvx512MovingQueries, kAvx512SplitMovingQueries;
#endif

} // namespace kindling::accel::kd
