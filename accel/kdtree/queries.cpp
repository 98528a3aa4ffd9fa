// SPDX-License-Identifier: Apache-2.0
#include "accel/kdtree/queries.h"

namespace kindling::accel::kd {

const Queries& queries_for(SimdTarget target) {
  switch (target) {
  case SimdTarget::portable: break;
#if defined(__x86_64__)
  case SimdTarget::avx2: return kAvx2Queries;
  case SimdTarget::avx512: return kAvx512Queries;
#else
  default: break;
#endif
  }
  return kPortableQueries;
}

} // namespace kindling::accel::kd
