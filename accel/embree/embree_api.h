// One set of names for Embree 3.13 and 4; other files need not know the version.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#if KINDLING_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <utility>

namespace kindling::accel::embree {

#if KINDLING_EMBREE_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
inline void init_context(QueryContext& context) { rtcInitRayQueryContext(&context); }
#else
using QueryContext = RTCIntersectContext;
inline void init_context(QueryContext& context) { rtcInitIntersectContext(&context); }
#endif

// The arguments of a series of queries by one thread; set up once, used for many rays. `coherent`
// affects packets and streams only.
class Query {
 public:
  explicit Query(QueryContext& context, bool coherent = false) : context_(context) {
    init_context(context);
#if KINDLING_EMBREE_MAJOR >= 4
    rtcInitIntersectArguments(&intersect_);
    intersect_.context = &context;
    rtcInitOccludedArguments(&occluded_);
    occluded_.context = &context;
    if (coherent) intersect_.flags = occluded_.flags = RTC_RAY_QUERY_FLAG_COHERENT;
#else
    if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
#endif
  }

  void intersect1(RTCScene scene, RTCRayHit& ray_hit) { intersect(rtcIntersect1, ray_hit, scene); }
  void occluded1(RTCScene scene, RTCRay& ray) { occluded(rtcOccluded1, ray, scene); }
  // Packets of the device's native_packet() width. valid[i] is -1 to trace ray i and 0 to skip it;
  // `valid` is aligned to 64 bytes.
  void intersect_packet(const int* valid, RTCScene scene, RTCRayHit4& ray_hits) {
    intersect(rtcIntersect4, ray_hits, valid, scene);
  }
  void intersect_packet(const int* valid, RTCScene scene, RTCRayHit8& ray_hits) {
    intersect(rtcIntersect8, ray_hits, valid, scene);
  }
  void intersect_packet(const int* valid, RTCScene scene, RTCRayHit16& ray_hits) {
    intersect(rtcIntersect16, ray_hits, valid, scene);
  }
  void occluded_packet(const int* valid, RTCScene scene, RTCRay4& rays) { occluded(rtcOccluded4, rays, valid, scene); }
  void occluded_packet(const int* valid, RTCScene scene, RTCRay8& rays) { occluded(rtcOccluded8, rays, valid, scene); }
  void occluded_packet(const int* valid, RTCScene scene, RTCRay16& rays) {
    occluded(rtcOccluded16, rays, valid, scene);
  }
#if KINDLING_EMBREE_MAJOR < 4
  // Streams of mixed rays; Embree 4 has none.
  void intersect_stream(RTCScene scene, RTCRayHit* ray_hits, unsigned count) {
    rtcIntersect1M(scene, &context_, ray_hits, count, sizeof(RTCRayHit));
  }
  void occluded_stream(RTCScene scene, RTCRay* rays, unsigned count) {
    rtcOccluded1M(scene, &context_, rays, count, sizeof(RTCRay));
  }
#endif

 private:
  // Calls an Embree function whose last two parameters changed order and type between versions 3
  // and 4.
  template <class Rays, class... First>
  void intersect(auto* function, Rays& rays, First... first) {
#if KINDLING_EMBREE_MAJOR >= 4
    function(first..., &rays, &intersect_);
#else
    function(first..., &context_, &rays);
#endif
  }
  template <class Rays, class... First>
  void occluded(auto* function, Rays& rays, First... first) {
#if KINDLING_EMBREE_MAJOR >= 4
    function(first..., &rays, &occluded_);
#else
    function(first..., &context_, &rays);
#endif
  }

  QueryContext& context_;
#if KINDLING_EMBREE_MAJOR >= 4
  RTCIntersectArguments intersect_;
  RTCOccludedArguments occluded_;
#endif
};

// Nested query from a user geometry's callback, as if that geometry were an instance of `scene`.
// `context` is the callback's.
inline void intersect_within(QueryContext* context, unsigned instance, RTCScene scene, RTCRayHit& ray_hit) {
  context->instID[0] = instance;
#if KINDLING_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = context;
  rtcIntersect1(scene, &ray_hit, &arguments);
#else
  rtcIntersect1(scene, context, &ray_hit);
#endif
  context->instID[0] = RTC_INVALID_GEOMETRY_ID;
}
inline void occluded_within(QueryContext* context, unsigned instance, RTCScene scene, RTCRay& ray) {
  context->instID[0] = instance;
#if KINDLING_EMBREE_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = context;
  rtcOccluded1(scene, &ray, &arguments);
#else
  rtcOccluded1(scene, context, &ray);
#endif
  context->instID[0] = RTC_INVALID_GEOMETRY_ID;
}

// Returns the widest packet that the device's kernels trace together: 16, 8, 4, or 1 for none.
// Embree splits wider packets at a cost, and 3.13 then ignores which rays are valid.
inline size_t native_packet(RTCDevice device) {
  const auto has = [device](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property) != 0; };
  if (has(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
  if (has(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return 8;
  return has(RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED) ? 4 : 1;
}

// Owns one reference of an Embree object.
template <class T, void (*release)(T)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(T object) : object_(object) {}
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  ~Handle() {
    if (object_ != nullptr) release(object_);
  }
  [[nodiscard]] T get() const { return object_; }
  [[nodiscard]] explicit operator bool() const { return object_ != nullptr; }

 private:
  T object_ = nullptr;
};
using Device = Handle<RTCDevice, rtcReleaseDevice>;
using Scene = Handle<RTCScene, rtcReleaseScene>;
using Geometry = Handle<RTCGeometry, rtcReleaseGeometry>;

} // namespace kindling::accel::embree
