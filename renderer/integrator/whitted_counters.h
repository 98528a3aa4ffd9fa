// Counts of the Whitted tracer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

// By one thread.
struct WhittedCounters {
  uint64_t reflection = 0;   // rays; RayCounters::bounce includes them
  uint64_t transmission = 0; // likewise
  uint64_t cache_hits = 0;
  uint64_t cache_misses = 0;   // computed and stored
  uint64_t cache_bypasses = 0; // surfaces whose parameters vary over the material
};

} // namespace kindling
