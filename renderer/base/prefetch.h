// Prefetching of cache lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/on_gpu.h"

namespace kindling {

// Brings the cache line of an address into the first-level cache; any address is allowed. On x86
// the instruction is written as assembly, because GCC treats functions that contain nothing but
// __builtin_prefetch as empty and drops the calls. GPUs hide latencies by other threads.
inline void prefetch([[maybe_unused]] const void* address) {
#if KINDLING_ON_GPU
#elif defined(__x86_64__)
  asm volatile("prefetcht0 (%0)" : : "r"(address));
#else
  __builtin_prefetch(address);
#endif
}

} // namespace kindling
