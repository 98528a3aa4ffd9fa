// Embree 3.13 and 4 behind one set of names: only this header and its includer know which one is there.
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

// The arguments of a run of queries by one thread; set up once, used for many rays. `coherent` matters to packets and streams.
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

  void intersect1(RTCScene scene, RTCRayHit& ray_hit) {
#if KINDLING_EMBREE_MAJOR >= 4
    rtcIntersect1(scene, &ray_hit, &intersect_);
#else
    rtcIntersect1(scene, &context_, &ray_hit);
#endif
  }
  void occluded1(RTCScene scene, RTCRay& ray) {
#if KINDLING_EMBREE_MAJOR >= 4
    rtcOccluded1(scene, &ray, &occluded_);
#else
    rtcOccluded1(scene, &context_, &ray);
#endif
  }
  // valid[i]: -1 to trace ray i, 0 to leave it alone; aligned to 64 bytes.
  void intersect16(const int* valid, RTCScene scene, RTCRayHit16& ray_hits) {
#if KINDLING_EMBREE_MAJOR >= 4
    rtcIntersect16(valid, scene, &ray_hits, &intersect_);
#else
    rtcIntersect16(valid, scene, &context_, &ray_hits);
#endif
  }
  void occluded16(const int* valid, RTCScene scene, RTCRay16& rays) {
#if KINDLING_EMBREE_MAJOR >= 4
    rtcOccluded16(valid, scene, &rays, &occluded_);
#else
    rtcOccluded16(valid, scene, &context_, &rays);
#endif
  }
#if KINDLING_EMBREE_MAJOR < 4
  // Streams of any rays; Embree 4 has none.
  void intersect_stream(RTCScene scene, RTCRayHit* ray_hits, unsigned count) {
    rtcIntersect1M(scene, &context_, ray_hits, count, sizeof(RTCRayHit));
  }
  void occluded_stream(RTCScene scene, RTCRay* rays, unsigned count) {
    rtcOccluded1M(scene, &context_, rays, count, sizeof(RTCRay));
  }
#endif

 private:
  QueryContext& context_;
#if KINDLING_EMBREE_MAJOR >= 4
  RTCIntersectArguments intersect_;
  RTCOccludedArguments occluded_;
#endif
};

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
