// Embree user-geometry callbacks that trace an instance with a double-precision transform.
// SPDX-License-Identifier: Apache-2.0
#include "accel/embree/embree_guarded.h"

#include "accel/motion.h"
#include "accel/triangle.h"

#include <algorithm>

namespace kindling::accel::embree {
namespace {

// Reports bounds clamped to Embree's limit, since Embree drops geometry beyond it. NaN means bounds
// that overflowed.
void bounds_callback(const RTCBoundsFunctionArguments* args) {
  constexpr float kMaxBound = 0.99f * kMaxCoordinate;
  const Imath::Box3f& box = static_cast<const GuardedInstance*>(args->geometryUserPtr)->bounds;
  Imath::V3f low, high;
  for (int k = 0; k < 3; ++k) {
    low[k] = box.min[k] > -kMaxBound ? std::min(box.min[k], kMaxBound) : -kMaxBound;
    high[k] = box.max[k] < kMaxBound ? std::max(box.max[k], -kMaxBound) : kMaxBound;
  }
  *args->bounds_o = {low.x, low.y, low.z, 0.0f, high.x, high.y, high.z, 0.0f};
}

// Computes the object-space ray of lane i in `out`. Returns false if it misses by definition.
bool ray_in_object_space(const GuardedInstance& instance, RTCRayN* rays, unsigned n, unsigned i, RTCRay& out) {
  Ray world;
  world.origin = {RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)};
  world.direction = {RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)};
  world.t_min = RTCRayN_tnear(rays, n, i);
  world.t_max = RTCRayN_tfar(rays, n, i);
  world.time = RTCRayN_time(rays, n, i);
  RayToObject to_object = instance.to_object;
  if (!instance.keys.empty() && !to_object.set_inverse_of(matrix_at(instance.keys, world.time))) return false;
  const Ray object = to_object(world);
  if (!can_hit(object)) return false;
  out.org_x = object.origin.x;
  out.org_y = object.origin.y;
  out.org_z = object.origin.z;
  out.tnear = object.t_min;
  out.dir_x = object.direction.x;
  out.dir_y = object.direction.y;
  out.dir_z = object.direction.z;
  out.time = world.time;
  out.tfar = object.t_max;
  out.mask = RTCRayN_mask(rays, n, i);
  out.id = RTCRayN_id(rays, n, i);
  out.flags = 0;
  return true;
}

void intersect_callback(const RTCIntersectFunctionNArguments* args) {
  const GuardedInstance& instance = *static_cast<const GuardedInstance*>(args->geometryUserPtr);
  RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; ++i) {
    RTCRayHit object;
    if (args->valid[i] != -1 || !ray_in_object_space(instance, rays, args->N, i, object.ray)) continue;
    object.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    intersect_within(args->context, args->geomID, instance.scene, object);
    if (object.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    RTCRayN_tfar(rays, args->N, i) = object.ray.tfar;
    RTCHitN_Ng_x(hits, args->N, i) = object.hit.Ng_x;
    RTCHitN_Ng_y(hits, args->N, i) = object.hit.Ng_y;
    RTCHitN_Ng_z(hits, args->N, i) = object.hit.Ng_z;
    RTCHitN_u(hits, args->N, i) = object.hit.u;
    RTCHitN_v(hits, args->N, i) = object.hit.v;
    RTCHitN_primID(hits, args->N, i) = object.hit.primID;
    RTCHitN_geomID(hits, args->N, i) = object.hit.geomID;
    RTCHitN_instID(hits, args->N, i, 0) = args->geomID;
  }
}

void occluded_callback(const RTCOccludedFunctionNArguments* args) {
  const GuardedInstance& instance = *static_cast<const GuardedInstance*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    RTCRay object;
    if (args->valid[i] != -1 || !ray_in_object_space(instance, args->ray, args->N, i, object)) continue;
    occluded_within(args->context, args->geomID, instance.scene, object);
    if (object.tfar < 0.0f) RTCRayN_tfar(args->ray, args->N, i) = object.tfar; // minus infinity: blocked
  }
}

} // namespace

Geometry guarded_geometry(RTCDevice device, GuardedInstance& instance) {
  Geometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER));
  rtcSetGeometryUserPrimitiveCount(geometry.get(), 1);
  rtcSetGeometryUserData(geometry.get(), &instance);
  rtcSetGeometryBoundsFunction(geometry.get(), bounds_callback, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), intersect_callback);
  rtcSetGeometryOccludedFunction(geometry.get(), occluded_callback);
  rtcCommitGeometry(geometry.get());
  return geometry;
}

} // namespace kindling::accel::embree
