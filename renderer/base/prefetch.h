// Asking for memory before it is needed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kindling {

// A hint: brings the cache line of an address to the first level, and may be given any address. Where the compiler knows the
// instruction it is written out, for GCC takes functions that do nothing but __builtin_prefetch for empty and drops the calls.
inline void prefetch(const void* address) {
#if defined(__x86_64__)
  asm volatile("prefetcht0 (%0)" : : "r"(address));
#else
  __builtin_prefetch(address);
#endif
}

} // namespace kindling
