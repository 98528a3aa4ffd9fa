// Embree user geometries for instances with transforms beyond Embree's limits.
//
// Instances that Embree's own cannot represent (embree_limits.h) become user geometries. They
// transform rays in double precision, as the other accelerators do, and query the group's scene
// only for rays that are finite in its space.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/affine.h"
#include "accel/embree/embree_api.h"

#include <ImathMatrix.h>

#include <vector>

namespace kindling::accel::embree {

struct GuardedInstance {
  RTCScene scene = nullptr; // scene of the group, committed; not owned
  RayToObject to_object;
  std::vector<Imath::M44f> keys; // matrices of a moving instance; empty if `to_object` is used
  Imath::Box3f bounds;           // in world space, valid at all times
};

// Creates a geometry that reports itself as the instance of its hits. `instance` must outlive it
// and stay at the same address.
[[nodiscard]] Geometry guarded_geometry(RTCDevice device, GuardedInstance& instance);

} // namespace kindling::accel::embree
