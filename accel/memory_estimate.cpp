// SPDX-License-Identifier: Apache-2.0
#include "accel/memory_estimate.h"

namespace kindling::accel {
namespace {

// What does not depend on the input: tables, arenas, the device.
constexpr uint64_t kFixed = 4U << 20;

} // namespace

MemoryCosts memory_costs(Kind kind) {
  switch (kind) {
  case Kind::brute_force: return {8, 80, 8, 80};
  // Leaf blocks and wide nodes of up to three references for each triangle. While it is built: references of 32 bytes, twice at the top
  // of the tree, and the binary tree. An instance has 64 bytes, and nodes of 256 for about six of them; in the build a box, and numbers.
  case Kind::kdtree: return {76, 116, 175, 190};
  // Leaves of up to four triangles with their vertices. An instance is an object of its own, with a matrix and its inverse.
  case Kind::embree: return {74, 370, 130, 480};
  }
  return {};
}

MemoryEstimate estimate_memory(Kind kind, uint64_t triangles, uint64_t instances) {
  const MemoryCosts costs = memory_costs(kind);
  return {kFixed + triangles * costs.triangle + instances * costs.instance,
          kFixed + triangles * costs.triangle_in_build + instances * costs.instance_in_build};
}

} // namespace kindling::accel
