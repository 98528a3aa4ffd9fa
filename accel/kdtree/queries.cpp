// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/queries.h"

namespace kindling::accel::kd {

const Queries& queries_for(SimdTarget target, bool moving) {
  switch (target) {
  case SimdTarget::portable: break;
#if defined(__x86_64__)
  case SimdTarget::avx2: return moving ? kAvx2MovingQueries : kAvx2Queries;
  case SimdTarget::avx512: return moving ? kAvx512MovingQueries : kAvx512Queries;
#else
  default: break;
#endif
  }
  return moving ? kPortableMovingQueries : kPortableQueries;
}

} // namespace kindling::accel::kd
