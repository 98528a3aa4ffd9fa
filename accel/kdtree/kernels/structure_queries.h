// Queries of a static scene: single rays, streams and coherent batches through all trees.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/instance_packet.h"
#include "accel/kdtree/kernels/instance_stream.h"
#include "accel/kdtree/kernels/instances.h"
#include "accel/kdtree/kernels/one_leaf.h"
#include "accel/kdtree/kernels/packet.h"
#include "accel/kdtree/kernels/stream.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

template <bool kAny>
inline bool trace_transformed(const Structure& s, const TransformedInstance& transformed, const Ray& world, float t_min,
                              float& t_far, Hit& hit) {
  const Ray ray = transformed.to_object(world);
  if (!can_hit(ray)) return false;
  const CandidateFilter filter{s.filter, world, *transformed.tree, transformed.instance};
  TreeHit in_tree;
  if (!trace_tree<kAny>(*transformed.tree, ray, t_min, filter, t_far, in_tree)) return false;
  if (kAny) return true;
  merge_hit(filter, in_tree, hit);
  return false;
}

// Continues after the world tree, from a node of the hierarchy on; `hit`, if any, is at t_far,
// which hits narrow.
template <bool kAny>
inline bool trace_instances_from(const Structure& s, uint32_t node, const Ray& world, float& t_far, Hit& hit) {
  const float t_min = std::max(world.t_min, 0.0f);
  const auto visit = [&](uint32_t i) {
    if (s.filter.abandoned()) [[unlikely]]
      return true;
    return trace_transformed<kAny>(s, s.transformed[i], world, t_min, t_far, hit);
  };
  return visit_instances<kAny>(s.instance_level, std::span(s.transformed), world, t_min, t_far, visit, node);
}
template <bool kAny>
inline bool trace_instances(const Structure& s, const Ray& world, float t_far, Hit& hit) {
  return trace_instances_from<kAny>(s, 0, world, t_far, hit);
}

template <bool kAny>
inline bool trace(const Structure& s, const Ray& world, Hit& hit) {
  if (!can_hit(world)) return false;
  const float t_min = std::max(world.t_min, 0.0f);
  float t_far = world.t_max;
  TreeHit in_world;
  const CandidateFilter filter{s.filter, world, s.world_tree, kNoId};
  if (trace_tree<kAny>(s.world_tree, world, t_min, filter, t_far, in_world)) {
    if (kAny) return true;
    hit = filter.resolve(in_world);
  }
  return trace_instances<kAny>(s, world, t_far, hit);
}

inline Hit intersect(const Structure& s, const Ray& ray) {
  Hit hit;
  trace<false>(s, ray, hit);
  return hit;
}

inline bool occluded(const Structure& s, const Ray& ray) {
  Hit hit;
  return trace<true>(s, ray, hit);
}

// The calls of a stream through transformed instances.
struct OfTransformed {
  const Structure& s;
  std::span<const Ray> rays;

  template <bool kAny>
  bool trace_whole(size_t i, Hit& hit) const {
    return trace<kAny>(s, rays[i], hit);
  }
  template <bool kAny>
  bool trace_one(size_t i, uint32_t number, float& t_far, Hit& hit) const {
    return trace_transformed<kAny>(s, s.transformed[number], rays[i], std::max(rays[i].t_min, 0.0f), t_far, hit);
  }
  template <bool kAny>
  [[gnu::noinline]] bool visit(size_t i, uint32_t node, float& t_far, Hit& hit) const {
    return trace_instances_from<kAny>(s, node, rays[i], t_far, hit);
  }
};

template <bool kAny, class Answer>
[[gnu::noinline]] void stream_transformed(const Structure& s, std::span<const Ray> rays, const Tree* world,
                                          std::span<Answer> answers) {
  InstanceStream<kAny, TransformedInstances> stream({s}, s.filter, world);
  stream.trace(rays, BatchAnswers<kAny, OfTransformed, Answer>{{s, rays}, answers});
}
inline bool streams_transformed(const Structure& s, std::span<const Ray> rays) {
  return rays.size() >= kMinStreamRays && s.instance_level.depth() <= TreesInTurn::kMaxDepth;
}

// Traces transformed instances after the world tree of a batch.
inline void add_instances(const Structure& s, std::span<const Ray> rays, std::span<Hit> hits) {
  if (s.instance_level.empty()) return;
  if (streams_transformed(s, rays)) return stream_transformed<false>(s, rays, nullptr, hits);
  for (size_t i = 0; i < rays.size(); ++i)
    if (can_hit(rays[i])) trace_instances<false>(s, rays[i], hits[i].is_hit() ? hits[i].t : rays[i].t_max, hits[i]);
}
inline void add_instances(const Structure& s, std::span<const Ray> rays, std::span<uint8_t> blocked) {
  if (s.instance_level.empty()) return;
  if (streams_transformed(s, rays)) return stream_transformed<true>(s, rays, nullptr, blocked);
  for (size_t i = 0; i < rays.size(); ++i) {
    Hit hit;
    if (blocked[i] == 0 && can_hit(rays[i])) blocked[i] = trace_instances<true>(s, rays[i], rays[i].t_max, hit) ? 1 : 0;
  }
}

// Traces a batch through the world's tree.
template <bool kAny, class Finish>
[[gnu::always_inline]] inline void trace_batch(const Structure& s, std::span<const Ray> rays, const Finish& finish) {
  if (is_one_leaf(s.world_tree)) return trace_one_leaf<kAny>(s.world_tree, s.filter, rays, finish);
  Stream<kAny> stream(s.world_tree, s.filter);
  stream.trace(rays, finish);
}

inline void intersect_stream(const Structure& s, std::span<const Ray> rays, std::span<Hit> hits) {
  if (rays.size() < kMinStreamRays) {
    for (size_t i = 0; i < rays.size(); ++i) hits[i] = intersect(s, rays[i]);
    return;
  }
  std::fill(hits.begin(), hits.end(), Hit());
  if (!s.instance_level.empty() && streams_transformed(s, rays))
    return stream_transformed<false>(s, rays, &s.world_tree, hits);
  trace_batch<false>(s, rays, [&](size_t i, const TreeHit& hit) {
    hits[i] = CandidateFilter{s.filter, rays[i], s.world_tree, kNoId}.resolve(hit);
  });
  add_instances(s, rays, hits);
}

inline void occluded_stream(const Structure& s, std::span<const Ray> rays, std::span<uint8_t> blocked) {
  if (rays.size() < kMinStreamRays) {
    for (size_t i = 0; i < rays.size(); ++i) blocked[i] = occluded(s, rays[i]) ? 1 : 0;
    return;
  }
  std::fill(blocked.begin(), blocked.end(), uint8_t{0});
  if (!s.instance_level.empty() && streams_transformed(s, rays))
    return stream_transformed<true>(s, rays, &s.world_tree, blocked);
  trace_batch<true>(s, rays, [&](size_t i, const TreeHit&) { blocked[i] = 1; });
  add_instances(s, rays, blocked);
}

// Traces rays of a coherent batch that are not worth packets: at most 256, by their indices.
template <bool kAny, class Finish>
[[gnu::noinline]] void trace_incoherent(const Structure& s, std::span<const Ray> rays,
                                        std::span<const uint32_t> numbers, const Finish& finish) {
  if (numbers.size() < kMinStreamRays) {
    for (const uint32_t i : numbers) trace_indexed<kAny>(s.world_tree, s.filter, rays, i, finish);
    return;
  }
  std::array<Ray, 256> incoherent;
  assert(numbers.size() <= incoherent.size());
  for (size_t k = 0; k < numbers.size(); ++k) incoherent[k] = rays[numbers[k]];
  trace_batch<kAny>(s, std::span<const Ray>(incoherent).first(numbers.size()),
                    [&](size_t k, const TreeHit& hit) { finish(numbers[k], hit); });
}

inline void intersect_coherent(const Structure& s, std::span<const Ray> rays, std::span<Hit> hits) {
  std::fill(hits.begin(), hits.end(), Hit());
  const auto finish = [&](size_t i, const TreeHit& hit) {
    hits[i] = CandidateFilter{s.filter, rays[i], s.world_tree, kNoId}.resolve(hit);
  };
  trace_packets<false>(s.world_tree, s.filter, rays, finish, [&](std::span<const uint32_t> incoherent) {
    trace_incoherent<false>(s, rays, incoherent, finish);
  });
  if (s.instance_level.empty()) return;
  trace_coherent_instances<false, OfTransformed>(s, TransformedInstances{s}, rays, hits);
}

inline void occluded_coherent(const Structure& s, std::span<const Ray> rays, std::span<uint8_t> blocked) {
  std::fill(blocked.begin(), blocked.end(), uint8_t{0});
  const auto finish = [&](size_t i, const TreeHit&) { blocked[i] = 1; };
  trace_packets<true>(s.world_tree, s.filter, rays, finish, [&](std::span<const uint32_t> incoherent) {
    trace_incoherent<true>(s, rays, incoherent, finish);
  });
  if (s.instance_level.empty()) return;
  trace_coherent_instances<true, OfTransformed>(s, TransformedInstances{s}, rays, blocked);
}

constexpr Queries make_queries() {
  return {intersect, occluded, intersect_stream, occluded_stream, intersect_coherent, occluded_coherent};
}

} // namespace kindling::accel::kd::KINDLING_SIMD
