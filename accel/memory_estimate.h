// Upper bounds of an accelerator's memory, estimated before the build.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"

#include <cstdint>

namespace kindling::accel {

// Bytes per triangle of a group, which instances share, and per instance that is not an identity.
// These are upper bounds: triangles of similar size that do not overlap take half as much, triangle
// soups more. tests/accel/test_memory.cpp checks builds against them.
struct MemoryCosts {
  uint64_t triangle = 0, instance = 0;                   // bytes held after the build
  uint64_t triangle_in_build = 0, instance_in_build = 0; // at the peak of the build, including what is held afterwards
};
[[nodiscard]] MemoryCosts memory_costs(Kind kind);

struct MemoryEstimate {
  uint64_t held = 0;     // upper bound of Statistics::memory_bytes
  uint64_t building = 0; // upper bound of the resident peak during the build, including `held`, without borrowed arrays
};
// `triangles` counts each group once; `instances` counts those with a transform.
[[nodiscard]] MemoryEstimate estimate_memory(Kind kind, uint64_t triangles, uint64_t instances);

} // namespace kindling::accel
