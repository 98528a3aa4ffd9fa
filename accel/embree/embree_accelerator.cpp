// SPDX-License-Identifier: Apache-2.0
#include "accel/embree/embree_accelerator.h"

#include "accel/affine.h"
#include "accel/embree/embree_api.h"
#include "accel/embree/embree_build.h"
#include "accel/triangle.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>

namespace kindling::accel {
namespace {

using embree::TopGeometry;

// What a filter callback finds behind Embree's context; the context must come first.
struct Context {
  embree::QueryContext embree;
  const Ray* rays = nullptr; // RTCRay::id counts from here
  const std::vector<TopGeometry>* top_geometries = nullptr;
  HitFilter filter;
};

constexpr size_t kPacket = 16;
constexpr size_t kLeastPacket = 5; // fewer rays are faster one by one

#if KINDLING_EMBREE_MAJOR < 4
constexpr size_t kStream = 128;
constexpr size_t kLeastStream = 4;
#endif

// Anything that stays a normal number when Embree scales it: denormals cost a quarter of the speed.
constexpr float kSmallestNear = 1e-30f;

// Embree's robust test lets u and v leave the triangle by rounding errors; a Hit lies inside.
Hit to_hit(const std::vector<TopGeometry>& top, float t, float u, float v, uint32_t triangle, uint32_t geometry,
           uint32_t instance) {
  u = std::min(std::max(u, 0.0f), 1.0f);
  v = std::min(std::max(v, 0.0f), 1.0f - u);
  if (instance == RTC_INVALID_GEOMETRY_ID) {
    const TopGeometry& still = top[geometry];
    return {t, u, v, still.instance, still.mesh, triangle};
  }
  const TopGeometry& moved = top[instance];
  return {t, u, v, moved.instance, moved.mesh + geometry, triangle};
}

void filter_callback(const RTCFilterFunctionNArguments* args) {
  const auto* context = reinterpret_cast<const Context*>(args->context);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const Ray& ray = context->rays[RTCRayN_id(args->ray, args->N, i)];
    const Hit candidate =
        to_hit(*context->top_geometries, RTCRayN_tfar(args->ray, args->N, i), RTCHitN_u(args->hit, args->N, i),
               RTCHitN_v(args->hit, args->N, i), RTCHitN_primID(args->hit, args->N, i),
               RTCHitN_geomID(args->hit, args->N, i), RTCHitN_instID(args->hit, args->N, i, 0));
    if (!context->filter.accept(context->filter.context, ray, candidate)) args->valid[i] = 0;
  }
}

class EmbreeAccelerator final : public Accelerator {
 public:
  EmbreeAccelerator(embree::BuiltScenes scenes, const BuildInput& input, const BuildOptions& options, double build_s)
      : scenes_(std::move(scenes)), scene_(scenes_.top.get()), filter_(input.filter), robust_(options.robust) {
    statistics_.build_s = build_s;
    statistics_.triangle_count = scenes_.triangle_count;
    statistics_.instance_count = input.instances.size();
    statistics_.memory_bytes =
        static_cast<size_t>(scenes_.memory_bytes->load()) + scenes_.top_geometries.capacity() * sizeof(TopGeometry);
    RTCBounds box;
    rtcGetSceneBounds(scene_, &box);
    if (box.lower_x <= box.upper_x)
      bounds_ = {{box.lower_x, box.lower_y, box.lower_z}, {box.upper_x, box.upper_y, box.upper_z}};
  }

  [[nodiscard]] Hit intersect(const Ray& ray) const override {
    Hit hit;
    intersect({&ray, 1}, {&hit, 1});
    return hit;
  }
  [[nodiscard]] bool occluded(const Ray& ray) const override {
    uint8_t blocked = 0;
    occluded({&ray, 1}, {&blocked, 1});
    return blocked != 0;
  }

  // One ray at a time: for mixed rays Embree's packets gain nothing here.
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override {
    Context context = make_context(rays.data());
    embree::Query query(context.embree);
    RTCRayHit ray_hit;
    for (size_t i = 0; i < rays.size(); ++i) {
      if (!can_hit(rays[i])) {
        hits[i] = Hit();
        continue;
      }
      fill(rays[i], static_cast<unsigned>(i), ray_hit.ray);
      ray_hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      ray_hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      query.intersect1(scene_, ray_hit);
      hits[i] = ray_hit.hit.geomID == RTC_INVALID_GEOMETRY_ID
                    ? Hit()
                    : to_hit(scenes_.top_geometries, ray_hit.ray.tfar, ray_hit.hit.u, ray_hit.hit.v, ray_hit.hit.primID,
                             ray_hit.hit.geomID, ray_hit.hit.instID[0]);
    }
  }

  // Embree 3 has streams for this: 1.1 to 1.8 times as fast as single rays. They use the same triangle test and, in robust mode,
  // conservative box tests, so that answers are equal; packets would be as fast, but their triangle test rounds differently.
  void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    Context context = make_context(rays.data());
    embree::Query query(context.embree);
    size_t first = 0;
#if KINDLING_EMBREE_MAJOR < 4
    std::array<RTCRay, kStream> stream;
    for (; rays.size() - first >= kLeastStream; first += std::min(kStream, rays.size() - first)) {
      const size_t count = std::min(kStream, rays.size() - first);
      unsigned valid = 0;
      for (size_t i = first; i < first + count; ++i) {
        blocked[i] = 0;
        if (can_hit(rays[i])) fill(rays[i], static_cast<unsigned>(i), stream[valid++]);
      }
      query.occluded_stream(scene_, stream.data(), valid);
      for (unsigned i = 0; i < valid; ++i)
        blocked[stream[i].id] = stream[i].tfar < 0.0f ? 1 : 0; // Embree sets minus infinity
    }
#endif
    RTCRay ray;
    for (; first < rays.size(); ++first) {
      blocked[first] = 0;
      if (!can_hit(rays[first])) continue;
      fill(rays[first], static_cast<unsigned>(first), ray);
      query.occluded1(scene_, ray);
      blocked[first] = ray.tfar < 0.0f ? 1 : 0;
    }
  }

  void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const override {
    Context context = make_context(rays.data());
    embree::Query query(context.embree, true);
    size_t first = 0;
    for (; rays.size() - first >= kLeastPacket; first += std::min(kPacket, rays.size() - first)) {
      alignas(64) int valid[kPacket];
      RTCRayHit16 packet;
      RTCHit16& found = packet.hit;
      const size_t count = fill_packet(rays, first, packet.ray, valid);
      for (size_t i = 0; i < kPacket; ++i) found.geomID[i] = found.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      query.intersect16(valid, scene_, packet);
      for (size_t i = 0; i < count; ++i)
        hits[first + i] = found.geomID[i] == RTC_INVALID_GEOMETRY_ID
                              ? Hit()
                              : to_hit(scenes_.top_geometries, packet.ray.tfar[i], found.u[i], found.v[i],
                                       found.primID[i], found.geomID[i], found.instID[0][i]);
    }
    if (first < rays.size()) intersect(rays.subspan(first), hits.subspan(first));
  }

  [[nodiscard]] Imath::Box3f bounds() const override { return bounds_; }
  [[nodiscard]] Statistics statistics() const override { return statistics_; }

 private:
  [[nodiscard]] Context make_context(const Ray* rays) const {
    Context context;
    context.rays = rays;
    context.top_geometries = &scenes_.top_geometries;
    context.filter = filter_;
    return context;
  }

  // Wide loads and stores only: Embree reads origin and direction as quadwords, and narrow stores just before that stall.
  void fill(const Ray& in, unsigned id, RTCRay& out) const {
    Quad origin = origin_quad(in), direction = direction_quad(in);
    out.tfar = direction[3];
    origin[3] = near_distance(in.t_min);
    direction[3] = in.time;
    static_assert(offsetof(RTCRay, tnear) == 12 && offsetof(RTCRay, dir_x) == 16 && offsetof(RTCRay, time) == 28);
    std::memcpy(reinterpret_cast<char*>(&out), &origin, sizeof(Quad));
    std::memcpy(reinterpret_cast<char*>(&out) + offsetof(RTCRay, dir_x), &direction, sizeof(Quad));
    out.mask = 0xffffffffU;
    out.id = id;
    out.flags = 0;
  }

  // Rays [first, first + 16) or as many as there are; returns how many. Those that miss by definition are not valid.
  size_t fill_packet(std::span<const Ray> rays, size_t first, RTCRay16& out, int* valid) const {
    const size_t count = std::min(kPacket, rays.size() - first);
    for (size_t i = 0; i < kPacket; ++i) {
      const Ray& in = rays[first + std::min(i, count - 1)];
      valid[i] = i < count && can_hit(in) ? -1 : 0;
      out.org_x[i] = in.origin.x;
      out.org_y[i] = in.origin.y;
      out.org_z[i] = in.origin.z;
      out.tnear[i] = near_distance(in.t_min);
      out.dir_x[i] = in.direction.x;
      out.dir_y[i] = in.direction.y;
      out.dir_z[i] = in.direction.z;
      out.time[i] = in.time;
      out.tfar[i] = in.t_max;
      out.mask[i] = 0xffffffffU;
      out.id[i] = static_cast<unsigned>(first + i);
      out.flags[i] = 0;
    }
    return count;
  }

  // Embree's robust test accepts t >= tnear, its fast one t > tnear; we promise t > t_min.
  [[nodiscard]] float near_distance(float t_min) const {
    if (!(t_min > 0.0f)) t_min = 0.0f;
    if (!robust_) return t_min;
    return std::max(std::bit_cast<float>(std::bit_cast<uint32_t>(t_min) + 1), kSmallestNear);
  }

  embree::BuiltScenes scenes_;
  RTCScene scene_;
  HitFilter filter_;
  bool robust_;
  Imath::Box3f bounds_;
  Statistics statistics_;
};

} // namespace

std::unique_ptr<Accelerator> make_embree(const BuildInput& input, const BuildOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  embree::BuiltScenes scenes;
  if (!embree::build_scenes(input, options, filter_callback, scenes)) return nullptr;
  const double build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return std::make_unique<EmbreeAccelerator>(std::move(scenes), input, options, build_s);
}

std::string_view embree_description() { return "Embree " RTC_VERSION_STRING; }

} // namespace kindling::accel
