// Upper bounds of an accelerator's memory, estimated before the build.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"

#include <cstdint>

namespace kindling::accel {

// Bytes per triangle of a group, which instances share, and per instance that is not an identity.
// These are upper bounds: triangles of similar size that do not overlap take half as much.
// tests/accel/test_memory.cpp and test_bounds.cpp check builds against them.
struct MemoryCosts {
  uint64_t triangle = 0, instance = 0;                   // bytes held after the build
  uint64_t triangle_in_build = 0, instance_in_build = 0; // at the peak of the build, including what is held afterwards
  // More for each vertex of a mesh beyond the number of its triangles, which few triangles share.
  uint64_t lone_vertex = 0, lone_vertex_in_build = 0;
};
[[nodiscard]] MemoryCosts memory_costs(Kind kind);

struct MemoryEstimate {
  uint64_t held = 0;     // upper bound of Statistics::memory_bytes
  uint64_t building = 0; // upper bound of the resident peak during the build, including `held`, without borrowed arrays
};
// `triangles` counts each group once; `instances` counts those with a transform. `lone_vertices`:
// the sum of lone_vertices() over the meshes.
[[nodiscard]] MemoryEstimate estimate_memory(Kind kind, uint64_t triangles, uint64_t instances,
                                             uint64_t lone_vertices = 0);
[[nodiscard]] constexpr uint64_t lone_vertices(uint64_t vertices, uint64_t triangles) {
  return vertices > triangles ? vertices - triangles : 0;
}

} // namespace kindling::accel
