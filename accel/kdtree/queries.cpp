// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/queries.h"

namespace kindling::accel::kd {
namespace {

struct QuerySet {
  const Queries &plain, &divided, &moving, &divided_moving;

  [[nodiscard]] const Queries& choose(QueryNeeds needs) const {
    if (needs.divided) return needs.moving ? divided_moving : divided;
    return needs.moving ? moving : plain;
  }
};

} // namespace

const Queries& queries_for(SimdTarget target, QueryNeeds needs) {
  switch (target) {
#if defined(__x86_64__)
  case SimdTarget::avx2:
    return QuerySet{kAvx2Queries, kAvx2DividedQueries, kAvx2MovingQueries, kAvx2DividedMovingQueries}.choose(needs);
  case SimdTarget::avx512:
    return QuerySet{kAvx512Queries, kAvx512DividedQueries, kAvx512MovingQueries, kAvx512DividedMovingQueries}.choose(
        needs);
#endif
  default: break;
  }
  return QuerySet{kPortableQueries, kPortableDividedQueries, kPortableMovingQueries, kPortableDividedMovingQueries}
      .choose(needs);
}

} // namespace kindling::accel::kd
