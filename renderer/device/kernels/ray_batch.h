// Rays that are traced for their own sake: their memory, and the two queries as kernels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/queries.h"
#include "accel/kdtree/view.h"
#include "accel/ray.h"

#include <cstdint>

namespace kindling {

// Pointers are addresses in the device's memory.
struct RayBatch {
  accel::kd::StructureView tree;
  const accel::Ray* rays = nullptr;
  accel::Hit* hits = nullptr;      // by ray
  uint32_t* are_blocked = nullptr; // by ray: 1 if anything is hit, else 0
};

namespace kernels {

inline void nearest_hit(const RayBatch& batch, uint32_t number) {
  batch.hits[number] = accel::kd::compact::intersect(batch.tree, batch.rays[number], accel::kd::compact::AcceptAll{});
}

inline void any_hit(const RayBatch& batch, uint32_t number) {
  batch.are_blocked[number] =
      accel::kd::compact::occluded(batch.tree, batch.rays[number], accel::kd::compact::AcceptAll{}) ? 1 : 0;
}

} // namespace kernels
} // namespace kindling
