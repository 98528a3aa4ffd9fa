// Function tables of the queries, compiled once per instruction set and selected at run time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/crossing_collector.h"
#include "accel/kdtree/crossing_batch.h"
#include "accel/kdtree/structure.h"
#include "accel/simd_target.h"

#include <cstdint>
#include <span>

namespace kindling::accel::kd {

// The semantics are those of Accelerator. All targets give the same answers bit for bit.
struct Queries {
  Hit (*intersect)(const Structure&, const Ray&);
  bool (*occluded)(const Structure&, const Ray&);
  void (*intersect_stream)(const Structure&, std::span<const Ray>, std::span<Hit>);
  void (*occluded_stream)(const Structure&, std::span<const Ray>, std::span<uint8_t>);
  void (*intersect_coherent)(const Structure&, std::span<const Ray>, std::span<Hit>);
  void (*occluded_coherent)(const Structure&, std::span<const Ray>, std::span<uint8_t>);
};

// Selects queries by structure: with moving instances, or with a world split into persistent and
// transient trees.
struct QueryNeeds {
  bool moving = false, split = false;
};
// Returns the queries of a target, which the processor must support; see simd_target.h.
[[nodiscard]] const Queries& queries_for(SimdTarget target, QueryNeeds needs);

// Queries of every crossing. Some are added several times with the same bits.
struct AllHitsQueries {
  // The ray satisfies can_hit().
  void (*single)(const Structure&, const Ray&, CrossingCollector&);
  // For a structure that is its world's tree alone.
  void (*stream)(const Structure&, std::span<const Ray>, CrossingBatch&);
};
[[nodiscard]] const AllHitsQueries& all_hits_queries_for(SimdTarget target);

// Defined in kernels/portable.cpp, kernels/split_portable.cpp, kernels/moving_portable.cpp,
// kernels/all_hits_portable.cpp and their counterparts for the other targets.
extern const Queries kPortableQueries, kPortableSplitQueries, kPortableMovingQueries, kPortableSplitMovingQueries;
extern const AllHitsQueries kPortableAllHits;
#if defined(__x86_64__)
extern const Queries kAvx2Queries, kAvx2SplitQueries, kAvx2MovingQueries, kAvx2SplitMovingQueries;
extern const Queries kAvx512Queries, kAvx512SplitQueries, kAvx512MovingQueries, kAvx512SplitMovingQueries;
extern const AllHitsQueries kAvx2AllHits, kAvx512AllHits;
#endif

} // namespace kindling::accel::kd
