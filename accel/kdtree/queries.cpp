// Selects the query table for an instruction set and a kind of structure.
// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/queries.h"

#include <cassert>

namespace kindling::accel::kd {
namespace {

struct QuerySet {
  const Queries &plain, &split, &moving, &split_moving;

  [[nodiscard]] const Queries& choose(QueryNeeds needs) const {
    if (needs.split) return needs.moving ? split_moving : split;
    return needs.moving ? moving : plain;
  }
};

} // namespace

const Queries& queries_for(SimdTarget target, QueryNeeds needs) {
  assert(target <= best_simd_target());
  switch (target) {
#if defined(__x86_64__)
  case SimdTarget::avx2:
    return QuerySet{kAvx2Queries, kAvx2SplitQueries, kAvx2MovingQueries, kAvx2SplitMovingQueries}.choose(needs);
  case SimdTarget::avx512:
    return QuerySet{kAvx512Queries, kAvx512SplitQueries, kAvx512MovingQueries, kAvx512SplitMovingQueries}.choose(needs);
#endif
  default: break;
  }
  return QuerySet{kPortableQueries, kPortableSplitQueries, kPortableMovingQueries, kPortableSplitMovingQueries}.choose(
      needs);
}

const AllHitsQueries& all_hits_queries_for(SimdTarget target) {
  assert(target <= best_simd_target());
  switch (target) {
#if defined(__x86_64__)
  case SimdTarget::avx2: return kAvx2AllHits;
  case SimdTarget::avx512: return kAvx512AllHits;
#endif
  default: return kPortableAllHits;
  }
}

} // namespace kindling::accel::kd
