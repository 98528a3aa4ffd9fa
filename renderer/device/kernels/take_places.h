// Places in lists that many threads append to at the same time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/on_gpu.h"

#include <cstdint>

namespace kindling::kernels {

// Adds `entries` to a counter and returns its value before. Threads that pass the same `key` must
// pass the same counter and the same number.
//
// An H100 adds to one address once in a nanosecond, so that a million threads would wait for each
// other. Those of a warp that come here together with the same key make one addition.
[[nodiscard]] inline uint32_t take_places(uint32_t& counter, uint32_t entries, uint32_t key) {
#if defined(__NVPTX__)
  const uint32_t same = __nvvm_match_any_sync_i32(__nvvm_activemask(), key);
  const uint32_t before = __builtin_popcount(same & __nvvm_read_ptx_sreg_lanemask_lt());
  uint32_t first = 0;
  if (before == 0) first = __atomic_fetch_add(&counter, entries * __builtin_popcount(same), __ATOMIC_RELAXED);
  return __nvvm_shfl_sync_idx_i32(same, first, __builtin_ctz(same), 31) + entries * before;
#else
  (void)key;
  return __atomic_fetch_add(&counter, entries, __ATOMIC_RELAXED);
#endif
}

} // namespace kindling::kernels
