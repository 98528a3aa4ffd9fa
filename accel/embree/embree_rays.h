// Conversion of rays and hits to Embree's formats and back, singly and in packets.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/affine.h"
#include "accel/embree/embree_api.h"
#include "accel/embree/embree_build.h"
#include "accel/motion.h"
#include "accel/triangle.h"
#include "accel/vectors.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <span>
#include <vector>

namespace kindling::accel::embree {

// Small enough to be negligible, but stays a normal number when Embree scales it: denormals cost a
// quarter of the speed.
inline constexpr float kMinNear = 1e-30f;

// Converts t_min to Embree's tnear. Embree's robust test accepts t >= tnear, its fast one t >
// tnear; the interface promises t > t_min.
[[nodiscard]] inline float near_distance(float t_min, bool robust) {
  if (!(t_min > 0.0f)) t_min = 0.0f;
  if (!robust) return t_min;
  return std::max(std::bit_cast<float>(std::bit_cast<uint32_t>(t_min) + 1), kMinNear);
}

// Returns true if Embree can trace the ray unchanged: it satisfies can_hit() and lies within
// safe_ray_extent() of all instances. Other rays that satisfy can_hit() start far away; see
// start_at_bounds().
[[nodiscard]] inline bool is_traceable(const Ray& ray, float ray_extent) { return can_hit(ray, ray_extent); }

// Returns true if the ray may join a stream too. Streams of Embree 3.13 sort rays by the signs of
// their directions, and take the reciprocal of a component between -1e-18 and 0 for a large
// positive one. Such a ray misses boxes that it should meet, and may visit a child that does not
// exist.
[[nodiscard]] inline bool is_streamable(const Ray& ray, float ray_extent) {
  const Float4 direction = load_direction(ray), zero{}; // lane 3 is t_max, positive for a traceable ray
  const auto tiny = (direction < zero) & (direction > zero - 1.1e-18f);
  return std::bit_cast<unsigned __int128>(tiny) == 0 && is_traceable(ray, ray_extent);
}

// Fills an Embree ray by wide loads and stores only: Embree reads origin and direction as
// quadwords, and narrow stores just before that stall.
inline void fill(const Ray& in, bool robust, unsigned id, RTCRay& out) {
  Float4 origin = load_origin(in), direction = load_direction(in);
  out.tfar = direction[3];
  origin[3] = near_distance(in.t_min, robust);
  direction[3] = clamped_time(in.time);
  static_assert(offsetof(RTCRay, tnear) == 12 && offsetof(RTCRay, dir_x) == 16 && offsetof(RTCRay, time) == 28);
  std::memcpy(reinterpret_cast<char*>(&out), &origin, sizeof(Float4));
  std::memcpy(reinterpret_cast<char*>(&out) + offsetof(RTCRay, dir_x), &direction, sizeof(Float4));
  out.mask = 0xffffffffU;
  out.id = id;
  out.flags = 0;
}

// Embree's types for packets of 4, 8 and 16 rays.
template <size_t width>
struct PacketOf;
template <>
struct PacketOf<4> {
  using Rays = RTCRay4;
  using RayHits = RTCRayHit4;
};
template <>
struct PacketOf<8> {
  using Rays = RTCRay8;
  using RayHits = RTCRayHit8;
};
template <>
struct PacketOf<16> {
  using Rays = RTCRay16;
  using RayHits = RTCRayHit16;
};

// Fills a packet with rays [first, first + width), or as many as there are; returns their number.
// `valid`, aligned to 64 bytes, is -1 for rays that Embree can trace (is_traceable()), else 0. Ids
// are indices into `rays`. Transposes four rays at a time to keep the conversion cheap.
template <size_t width>
size_t fill_packet(std::span<const Ray> rays, size_t first, bool robust, float ray_extent,
                   typename PacketOf<width>::Rays& out, int* valid) {
  assert(first < rays.size() && reinterpret_cast<uintptr_t>(valid) % 64 == 0);
  const size_t count = std::min(width, rays.size() - first);
  const auto magnitude = [](Float4 q) { return std::bit_cast<Float4>(std::bit_cast<Int4>(q) & 0x7fffffff); };
  for (size_t i = 0; i < width; i += 4) {
    Float4 origin[4], direction[4], time;
    for (size_t k = 0; k < 4; ++k) {
      const Ray& in = rays[first + std::min(i + k, count - 1)];
      origin[k] = load_origin(in);
      direction[k] = load_direction(in);
      time[k] = in.time;
    }
    transpose(origin);
    transpose(direction);
    const Float4 zero{}, one = zero + 1.0f;
    time = time > zero ? (time < one ? time : one) : zero; // as clamped_time()
    const Float4 t_min = origin[3], t_max = direction[3];
    const Float4 sum = (magnitude(origin[0]) + magnitude(origin[1]) + magnitude(origin[2])) +
                       (magnitude(direction[0]) + magnitude(direction[1]) + magnitude(direction[2]));
    const Int4 points = (direction[0] != zero) | (direction[1] != zero) | (direction[2] != zero);
    const auto index = static_cast<int32_t>(i);
    const Int4 lane{index, index + 1, index + 2, index + 3};
    const Int4 traceable = (sum <= ray_extent) & points & (t_min < t_max) & (t_max > zero) & // as is_traceable()
                           (lane < static_cast<int32_t>(count));
    Float4 near = t_min > zero ? t_min : zero; // as near_distance()
    if (robust) {
      near = std::bit_cast<Float4>(std::bit_cast<Int4>(near) + 1);
      near = near > kMinNear ? near : zero + kMinNear;
    }
    const Int4 id = lane + static_cast<int32_t>(first), all = Int4{} - 1, none{};
    const auto store = [i](auto* row, auto vector) { std::memcpy(row + i, &vector, sizeof vector); };
    store(valid, traceable);
    store(out.org_x, origin[0]);
    store(out.org_y, origin[1]);
    store(out.org_z, origin[2]);
    store(out.tnear, near);
    store(out.dir_x, direction[0]);
    store(out.dir_y, direction[1]);
    store(out.dir_z, direction[2]);
    store(out.time, time);
    store(out.tfar, t_max);
    store(out.mask, all);
    store(out.id, id);
    store(out.flags, none);
  }
  return count;
}

// Makes a Hit from Embree's ids. Embree's robust test lets u and v leave the triangle by rounding
// errors; they are clamped to it.
[[nodiscard]] inline Hit to_hit(const GeometryNames& names, float t, float u, float v, uint32_t triangle,
                                uint32_t geometry, uint32_t instance) {
  u = std::min(std::max(u, 0.0f), 1.0f);
  v = std::min(std::max(v, 0.0f), 1.0f - u);
  if (instance == RTC_INVALID_GEOMETRY_ID) {
    assert(geometry < names.top.size());
    const NamedGeometry& named = names.top[geometry];
    return {t, u, v, named.instance, named.mesh, triangle};
  }
  assert(instance < names.top.size());
  const NamedGeometry& instanced = names.top[instance];
  if (instanced.instance == kNoId) {
    assert(geometry < names.persistent.size());
    const NamedGeometry& named = names.persistent[geometry];
    return {t, u, v, named.instance, named.mesh, triangle};
  }
  return {t, u, v, instanced.instance, instanced.mesh + geometry, triangle};
}

// Marks a hit record as a miss before tracing.
inline void clear(RTCHit& hit) {
  hit.geomID = RTC_INVALID_GEOMETRY_ID;
  hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}
[[nodiscard]] inline Hit hit_of(const GeometryNames& names, const RTCRayHit& found) {
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return to_hit(names, found.ray.tfar, found.hit.u, found.hit.v, found.hit.primID, found.hit.geomID,
                found.hit.instID[0]);
}
// HitPacket is RTCHit4, 8 or 16; RayHitPacket the RTCRayHit of the same width.
template <class HitPacket>
void clear_packet(HitPacket& hit) {
  for (size_t i = 0; i < std::size(hit.geomID); ++i) hit.geomID[i] = hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
}
template <class RayHitPacket>
[[nodiscard]] Hit hit_of(const GeometryNames& names, const RayHitPacket& found, size_t i) {
  const auto& hit = found.hit;
  if (hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) return {};
  return to_hit(names, found.ray.tfar[i], hit.u[i], hit.v[i], hit.primID[i], hit.geomID[i], hit.instID[0][i]);
}

} // namespace kindling::accel::embree
