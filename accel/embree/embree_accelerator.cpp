// The Embree accelerator: single rays, packets and streams over Embree's scenes.
// SPDX-License-Identifier: Apache-2.0
#include "accel/embree/embree_accelerator.h"

#include "accel/embree/embree_api.h"
#include "accel/embree/embree_build.h"
#include "accel/embree/embree_context.h"
#include "accel/embree/embree_limits.h"
#include "accel/embree/embree_rays.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <optional>

namespace kindling::accel {
namespace {

using embree::Context;
using embree::PacketOf;

// Bytes of a geometry object, which Embree's memory monitor does not count; measured with ten
// million of them.
constexpr size_t kGeometryObject = 250;
// Packets of fewer rays are slower than single rays.
template <size_t width>
constexpr size_t kMinPacket = width == 4 ? 3 : 5;
constexpr bool kHasStreams = KINDLING_EMBREE_MAJOR < 4;
constexpr size_t kStream = 128;
constexpr size_t kMinStream = 4;

class EmbreeAccelerator final : public Accelerator {
 public:
  EmbreeAccelerator(embree::BuiltScenes scenes, const BuildInput& input, const BuildOptions& options, double build_s)
      : scenes_(std::move(scenes)), scene_(scenes_.top()), filter_(input.filter), robust_(options.robust) {
    statistics_.build_s = build_s;
    statistics_.triangle_count = scenes_.triangle_count;
    statistics_.built_triangle_count = scenes_.built_triangle_count;
    statistics_.simd = simd_of_device();
    quality_ = options.quality;
    if (options.all_hits) crossing_scene_ = std::make_unique<embree::CrossingScene>(input);
    packet_ = embree::native_packet(scenes_.on.device.get());
    statistics_.instance_count = input.instances.size();
    statistics_.memory_bytes = static_cast<size_t>(scenes_.on.memory_bytes->load()) +
                               (scenes_.names.top.capacity() + scenes_.names.persistent.capacity()) *
                                   (sizeof(embree::NamedGeometry) + kGeometryObject) +
                               (crossing_scene_ ? crossing_scene_->memory_bytes() : 0);
    // True if the top scene holds instances, including that of the persistent scene.
    has_instances_ =
        (scenes_.persistent && scenes_.own_top) ||
        std::any_of(scenes_.groups.begin(), scenes_.groups.end(), [](const embree::Scene& s) { return !!s; });
    RTCBounds box;
    rtcGetSceneBounds(scene_, &box);
    if (box.lower_x <= box.upper_x)
      bounds_ = {{box.lower_x, box.lower_y, box.lower_z}, {box.upper_x, box.upper_y, box.upper_z}};
    else
      scenes_.ray_extent = -1.0f; // nothing can be hit, so no ray is traced
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

  // Traces one ray at a time: for mixed rays Embree's packets gain nothing here.
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override {
    assert(hits.size() == rays.size());
    Context context = make_context(rays.data());
    embree::Query query(context.embree);
    intersect_singly(rays, hits, 0, query);
  }
  // Uses Embree 3's streams, 1.1 to 1.8 times as fast as single rays. They use the same triangle
  // test and, in robust mode, conservative box tests, so that answers are equal. Packets would be
  // as fast, but their triangle test rounds differently.
  void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    if (kHasStreams) {
      occluded_by_streams(rays, blocked, false);
    } else {
      Context context = make_context(rays.data());
      embree::Query query(context.embree);
      occluded_singly(rays, blocked, 0, query);
    }
  }
  [[nodiscard]] bool coherent_equals_single() const override { return false; }
  void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const override {
    intersect_by_packets(rays, hits, true);
  }
  // Leaves out the coherent flag: any-hit packets are 1.1 to 2 times as fast without it, even for
  // the shadow rays of one tile.
  void occluded_coherent(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    occluded_by_packets(rays, blocked, false);
  }

  // Final packets of fewer than kMinPacket rays, and streams of fewer than kMinStream rays, are
  // traced as single rays.
  void intersect_by_packets(std::span<const Ray> rays, std::span<Hit> hits, bool coherent) const {
    assert(hits.size() == rays.size());
    switch (packet_) {
    case 16: return intersect_by_packets_of<16>(rays, hits, coherent);
    case 8: return intersect_by_packets_of<8>(rays, hits, coherent);
    case 4: return intersect_by_packets_of<4>(rays, hits, coherent);
    default: intersect(rays, hits);
    }
  }
  void occluded_by_packets(std::span<const Ray> rays, std::span<uint8_t> blocked, bool coherent) const {
    assert(blocked.size() == rays.size());
    switch (packet_) {
    case 16: return occluded_by_packets_of<16>(rays, blocked, coherent);
    case 8: return occluded_by_packets_of<8>(rays, blocked, coherent);
    case 4: return occluded_by_packets_of<4>(rays, blocked, coherent);
    default: occluded(rays, blocked);
    }
  }
  void intersect_by_streams(std::span<const Ray> rays, std::span<Hit> hits, bool coherent) const {
    assert(hits.size() == rays.size());
    Context context = make_context(rays.data());
    embree::Query query(context.embree, coherent);
    size_t first = 0;
#if KINDLING_EMBREE_MAJOR < 4
    std::array<RTCRayHit, kStream> stream;
    for (; rays.size() - first >= kMinStream; first += std::min(kStream, rays.size() - first)) {
      if (filter_.abandoned()) return;
      const size_t count = std::min(kStream, rays.size() - first);
      unsigned valid = 0;
      for (size_t i = first; i < first + count; ++i) {
        if (!embree::is_streamable(rays[i], scenes_.ray_extent)) {
          Context single = make_context(rays.data());
          embree::Query single_query(single.embree);
          intersect_singly(rays.first(i + 1), hits, i, single_query);
          continue;
        }
        embree::clear(stream[valid].hit);
        embree::fill(rays[i], robust_, static_cast<unsigned>(i), stream[valid++].ray);
      }
      query.intersect_stream(scene_, stream.data(), valid);
      for (unsigned i = 0; i < valid; ++i) hits[stream[i].ray.id] = embree::hit_of(scenes_.names, stream[i]);
    }
#endif
    intersect_singly(rays, hits, first, query);
  }
  void occluded_by_streams(std::span<const Ray> rays, std::span<uint8_t> blocked, bool coherent) const {
    assert(blocked.size() == rays.size());
    Context context = make_context(rays.data());
    embree::Query query(context.embree, coherent && !has_instances_);
    size_t first = 0;
#if KINDLING_EMBREE_MAJOR < 4
    std::array<RTCRay, kStream> stream;
    for (; rays.size() - first >= kMinStream; first += std::min(kStream, rays.size() - first)) {
      if (filter_.abandoned()) return;
      const size_t count = std::min(kStream, rays.size() - first);
      unsigned valid = 0;
      for (size_t i = first; i < first + count; ++i) {
        if (embree::is_streamable(rays[i], scenes_.ray_extent)) {
          embree::fill(rays[i], robust_, static_cast<unsigned>(i), stream[valid++]);
        } else {
          Context single = make_context(rays.data());
          embree::Query single_query(single.embree);
          occluded_singly(rays.first(i + 1), blocked, i, single_query);
        }
      }
      query.occluded_stream(scene_, stream.data(), valid);
      for (unsigned i = 0; i < valid; ++i) blocked[stream[i].id] = stream[i].tfar < 0.0f ? 1 : 0;
    }
#endif
    occluded_singly(rays, blocked, first, query);
  }

  // Searches a little beyond the interval, since Embree's distances are rounded otherwise.
  [[nodiscard]] bool all_hits(const Ray& ray, size_t limit, std::vector<Crossing>& crossings) const override {
    crossings.clear();
    if (!crossing_scene_) return false;
    if (!can_hit(ray) || filter_.abandoned()) return true;
    embree::Crossings found(*crossing_scene_, ray, limit, crossings);
    Ray longer = ray;
    longer.t_min *= 1.0f - 1e-4f;
    longer.t_max *= 1.0f + 1e-4f;
    (void)(embree::is_traceable(longer, scenes_.ray_extent) ? trace_one(longer, nullptr, &found)
                                                            : intersect_distant(longer, &found));
    found.finish();
    return true;
  }

  [[nodiscard]] Imath::Box3f bounds() const override { return bounds_; }
  [[nodiscard]] Statistics statistics() const override { return statistics_; }

  [[nodiscard]] std::unique_ptr<PersistentStructures> take_structures() override {
    auto out = std::make_unique<embree::PersistentScenes>();
    out->quality = quality_;
    out->robust = robust_;
    out->filters = embree::filters_for(filter_, crossing_scene_ != nullptr);
    scenes_.own_top = embree::Scene(); // before the scenes that it instances
    if (scenes_.persistent) out->scenes.put(std::move(scenes_.persistent_meshes), std::move(scenes_.persistent));
    for (size_t g = 0; g < scenes_.groups.size(); ++g)
      if (scenes_.groups[g]) out->scenes.put(std::move(scenes_.group_meshes[g]), std::move(scenes_.groups[g]));
    scenes_.groups.clear(); // before the device is released
    scenes_.persistent = embree::Scene();
    if (out->scenes.empty()) return nullptr;
    out->on = std::move(scenes_.on);
    return out;
  }

 private:
  [[nodiscard]] Context make_context(const Ray* rays) const {
    Context context;
    context.rays = rays;
    context.names = &scenes_.names;
    context.filter = filter_;
    return context;
  }

  // Infers the kernels that Embree selected from the packet width of the device.
  [[nodiscard]] SimdTarget simd_of_device() const {
    if (scenes_.on.simd) return *scenes_.on.simd;
    SimdTarget found = SimdTarget::portable;
    for (const SimdTarget target : embree_simd_targets())
      if (target <= widest_with(embree::native_packet(scenes_.on.device.get()))) found = target;
    return found;
  }
  [[nodiscard]] static SimdTarget widest_with(size_t packet) {
    return packet == 16 ? SimdTarget::avx512 : packet == 8 ? SimdTarget::avx2 : SimdTarget::sse42;
  }

  template <size_t width>
  void intersect_by_packets_of(std::span<const Ray> rays, std::span<Hit> hits, bool coherent) const {
    Context context = make_context(rays.data());
    embree::Query query(context.embree, coherent);
    size_t first = 0;
    for (; rays.size() - first >= kMinPacket<width>; first += std::min(width, rays.size() - first)) {
      if (filter_.abandoned()) return;
      alignas(64) int valid[width];
      typename PacketOf<width>::RayHits packet;
      const size_t count = embree::fill_packet<width>(rays, first, robust_, scenes_.ray_extent, packet.ray, valid);
      embree::clear_packet(packet.hit);
      query.intersect_packet(valid, scene_, packet);
      for (size_t i = 0; i < count; ++i)
        hits[first + i] = valid[i] != 0 ? embree::hit_of(scenes_.names, packet, i) : intersect_distant(rays[first + i]);
    }
    intersect_singly(rays, hits, first, query);
  }
  // Any-hit queries leave out the coherent flag in scenes with instances: there rtcOccluded16 and
  // rtcOccluded1M of Embree 3.13.5 never return for some rays (see
  // tests/accel/test_embree_calls.cpp).
  template <size_t width>
  void occluded_by_packets_of(std::span<const Ray> rays, std::span<uint8_t> blocked, bool coherent) const {
    Context context = make_context(rays.data());
    embree::Query query(context.embree, coherent && !has_instances_);
    size_t first = 0;
    for (; rays.size() - first >= kMinPacket<width>; first += std::min(width, rays.size() - first)) {
      if (filter_.abandoned()) return;
      alignas(64) int valid[width];
      typename PacketOf<width>::Rays packet;
      const size_t count = embree::fill_packet<width>(rays, first, robust_, scenes_.ray_extent, packet, valid);
      query.occluded_packet(valid, scene_, packet);
      for (size_t i = 0; i < count; ++i) // Embree sets tfar to minus infinity
        blocked[first + i] = (valid[i] != 0 ? packet.tfar[i] < 0.0f : occluded_distant(rays[first + i])) ? 1 : 0;
    }
    occluded_singly(rays, blocked, first, query);
  }

  // Traces a ray, or the one that starts in its place. With `crossings` nothing is hit.
  [[nodiscard]] Hit trace_one(const Ray& ray, const embree::StartedRay* started, embree::Crossings* crossings) const {
    Context context = make_context(&ray);
    context.started = started;
    context.crossings = crossings;
    embree::Query query(context.embree);
    RTCRayHit ray_hit;
    embree::fill(started != nullptr ? started->ray : ray, robust_, 0, ray_hit.ray);
    embree::clear(ray_hit.hit);
    query.intersect1(scene_, ray_hit);
    return embree::hit_of(scenes_.names, ray_hit);
  }
  // For rays that are not traceable: a miss, unless they start far away.
  [[nodiscard, gnu::noinline]] Hit intersect_distant(const Ray& ray, embree::Crossings* crossings = nullptr) const {
    const std::optional<embree::StartedRay> started = start(ray);
    if (!started) return {};
    Hit hit = trace_one(ray, &*started, crossings);
    if (hit.is_hit()) hit.t = started->world_t(ray, hit.t);
    return hit;
  }
  [[nodiscard, gnu::noinline]] bool occluded_distant(const Ray& ray) const {
    const std::optional<embree::StartedRay> started = start(ray);
    if (!started) return false;
    Context context = make_context(&ray);
    context.started = &*started;
    embree::Query query(context.embree);
    RTCRay out;
    embree::fill(started->ray, robust_, 0, out);
    query.occluded1(scene_, out);
    return out.tfar < 0.0f;
  }
  [[nodiscard]] std::optional<embree::StartedRay> start(const Ray& ray) const {
    if (!can_hit(ray)) return std::nullopt;
    std::optional<embree::StartedRay> started = embree::start_at_bounds(ray, bounds_);
    if (started && !embree::is_traceable(started->ray, scenes_.ray_extent)) started.reset(); // its interval is empty
    return started;
  }

  // Traces rays[first] and all after it.
  void intersect_singly(std::span<const Ray> rays, std::span<Hit> hits, size_t first, embree::Query& query) const {
    RTCRayHit ray_hit;
    for (; first < rays.size() && !filter_.abandoned(); ++first) {
      if (!embree::is_traceable(rays[first], scenes_.ray_extent)) {
        hits[first] = intersect_distant(rays[first]);
        continue;
      }
      embree::fill(rays[first], robust_, static_cast<unsigned>(first), ray_hit.ray);
      embree::clear(ray_hit.hit);
      query.intersect1(scene_, ray_hit);
      hits[first] = embree::hit_of(scenes_.names, ray_hit);
    }
  }
  void occluded_singly(std::span<const Ray> rays, std::span<uint8_t> blocked, size_t first,
                       embree::Query& query) const {
    RTCRay ray;
    for (; first < rays.size() && !filter_.abandoned(); ++first) {
      if (!embree::is_traceable(rays[first], scenes_.ray_extent)) {
        blocked[first] = occluded_distant(rays[first]) ? 1 : 0;
        continue;
      }
      embree::fill(rays[first], robust_, static_cast<unsigned>(first), ray);
      query.occluded1(scene_, ray);
      blocked[first] = ray.tfar < 0.0f ? 1 : 0;
    }
  }

  embree::BuiltScenes scenes_;
  RTCScene scene_;
  HitFilter filter_;
  std::unique_ptr<const embree::CrossingScene> crossing_scene_; // if all_hits() is prepared
  Quality quality_ = Quality::balanced;
  bool robust_;
  bool has_instances_ = false;
  size_t packet_ = 1; // rays that the device's kernels trace together
  Imath::Box3f bounds_;
  Statistics statistics_;
};

// Adapter that answers all batch queries by one of Embree's calls.
class OneCall final : public Accelerator {
 public:
  OneCall(const EmbreeAccelerator& embree, EmbreeCall call)
      : embree_(embree), streams_(call == EmbreeCall::stream || call == EmbreeCall::coherent_stream),
        coherent_(call == EmbreeCall::coherent_packet || call == EmbreeCall::coherent_stream) {}

  [[nodiscard]] Hit intersect(const Ray& ray) const override { return embree_.intersect(ray); }
  [[nodiscard]] bool occluded(const Ray& ray) const override { return embree_.occluded(ray); }
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const override {
    streams_ ? embree_.intersect_by_streams(rays, hits, coherent_)
             : embree_.intersect_by_packets(rays, hits, coherent_);
  }
  void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked) const override {
    streams_ ? embree_.occluded_by_streams(rays, blocked, coherent_)
             : embree_.occluded_by_packets(rays, blocked, coherent_);
  }
  void intersect_coherent(std::span<const Ray> rays, std::span<Hit> hits) const override { intersect(rays, hits); }
  [[nodiscard]] Imath::Box3f bounds() const override { return embree_.bounds(); }
  [[nodiscard]] Statistics statistics() const override { return embree_.statistics(); }

 private:
  const EmbreeAccelerator& embree_;
  bool streams_, coherent_;
};

} // namespace

std::unique_ptr<Accelerator> make_embree(const BuildInput& input, const BuildOptions& options,
                                         std::unique_ptr<PersistentStructures> previous) {
  const auto start = std::chrono::steady_clock::now();
  const embree::Filters filters = embree::filters_for(input.filter, options.all_hits);
  std::unique_ptr<embree::PersistentScenes> usable;
  if (auto* scenes = dynamic_cast<embree::PersistentScenes*>(previous.get());
      scenes != nullptr && scenes->quality == options.quality && scenes->robust == options.robust &&
      scenes->on.simd == options.simd && scenes->filters == filters) {
    (void)previous.release();
    usable.reset(scenes);
  }
  previous.reset();
  embree::BuiltScenes scenes;
  if (!embree::build_scenes(input, options, filters, std::move(usable), scenes)) return nullptr;
  const double build_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return std::make_unique<EmbreeAccelerator>(std::move(scenes), input, options, build_s);
}

std::string_view embree_description() { return "Embree " RTC_VERSION_STRING; }

std::unique_ptr<Accelerator> with_embree_call(const Accelerator& embree, EmbreeCall call) {
  const auto* built = dynamic_cast<const EmbreeAccelerator*>(&embree);
  const bool streams = call == EmbreeCall::stream || call == EmbreeCall::coherent_stream;
  if (built == nullptr || (streams && !kHasStreams)) return nullptr;
  return std::make_unique<OneCall>(*built, call);
}

} // namespace kindling::accel
