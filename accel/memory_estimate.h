// What an accelerator will take, before it is built.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"

#include <cstdint>

namespace kindling::accel {

// Bytes for each triangle of a group, which instances share, and for each instance that is not an identity. Upper bounds: triangles
// of like size that do not overlap take half as much, soups more. tests/accel/test_memory_estimate.cpp holds builds to them.
struct MemoryCosts {
  uint64_t triangle = 0, instance = 0;                   // held
  uint64_t triangle_in_build = 0, instance_in_build = 0; // at the peak of the build, what is held included
};
[[nodiscard]] MemoryCosts memory_costs(Kind kind);

struct MemoryEstimate {
  uint64_t held = 0;     // Statistics::memory_bytes, at most
  uint64_t building = 0; // resident at the peak of the build, at most: held included, the borrowed arrays not
};
// `triangles` in groups, each once; `instances` that are moved.
[[nodiscard]] MemoryEstimate estimate_memory(Kind kind, uint64_t triangles, uint64_t instances);

} // namespace kindling::accel
