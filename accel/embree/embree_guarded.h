// Instances that Embree's own cannot hold (embree_limits.h): user geometries that transform rays themselves, in double precision, as
// the other accelerators do, and ask the scene of the group only about rays that are finite in its space.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/affine.h"
#include "accel/embree/embree_api.h"

#include <ImathMatrix.h>

#include <vector>

namespace kindling::accel::embree {

struct GuardedInstance {
  RTCScene scene = nullptr; // of its group, committed; not owned
  RayToObject to_object;
  std::vector<Imath::M44f> keys; // of a moving one; empty: `to_object` serves
  Imath::Box3f bounds;           // in world space, at all times
};

// A geometry that names itself as the instance of its hits. `instance` must outlive it and stay where it is.
[[nodiscard]] Geometry guarded_geometry(RTCDevice device, GuardedInstance& instance);

} // namespace kindling::accel::embree
