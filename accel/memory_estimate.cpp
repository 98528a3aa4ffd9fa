// Memory costs per triangle and per instance, measured for each kind of accelerator.
// SPDX-License-Identifier: Apache-2.0
#include "accel/memory_estimate.h"

namespace kindling::accel {
namespace {

// Memory that does not depend on the input: tables, arenas, the Embree device, and the references
// that every kd-tree may have (kSpareReferences).
constexpr uint64_t kFixed = 12U << 20;

} // namespace

MemoryCosts memory_costs(Kind kind) {
  switch (kind) {
  case Kind::brute_force: return {8, 80, 8, 80};
  // Finished: leaf blocks and nodes for three references per triangle, which the build ensures
  // (Config::expected_references()); a reference takes 21 bytes, up to 46 if it shares no vertex.
  // During the build: references of 32 bytes, and the binary tree. An instance has 64 bytes, plus a
  // node of 256 bytes for about six of them; during the build also a box and index arrays.
  case Kind::kdtree: return {64, 116, 168, 190, 40, 110};
  // Leaves hold up to four triangles with their vertices. Each instance is an object with a matrix
  // and its inverse. Embree 4.3 takes half as much more for it as Embree 3.13.
  case Kind::embree:
    return KINDLING_EMBREE_MAJOR >= 4 ? MemoryCosts{74, 545, 130, 655} : MemoryCosts{74, 370, 130, 480};
  }
  return {};
}

MemoryEstimate estimate_memory(Kind kind, uint64_t triangles, uint64_t instances, uint64_t lone_vertices) {
  const MemoryCosts costs = memory_costs(kind);
  return {kFixed + triangles * costs.triangle + instances * costs.instance + lone_vertices * costs.lone_vertex,
          kFixed + triangles * costs.triangle_in_build + instances * costs.instance_in_build +
              lone_vertices * costs.lone_vertex_in_build};
}

} // namespace kindling::accel
