// Queries for scenes with moving or deforming instances.
// The queries without motion run first and know nothing of time; moving instances are then traced
// ray by ray. Scenes without motion never use this code. It is compiled separately, so that the
// other queries stay unchanged.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/instance_packet.h"
#include "accel/kdtree/kernels/instance_stream.h"
#include "accel/kdtree/kernels/instances.h"
#include "accel/kdtree/kernels/moving_entry.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Returns true if the ray enters the box of an instance at its time, which is far cheaper to test
// than inverting a matrix.
inline bool enters(const MovingInstance& moving, const KeyInterval& at, const Ray& ray, float t_min, float t_far,
                   float margin) {
  float enter = t_min * kBefore, leave = t_far * kWiden;
  return clip_to_box(moving.boxes[at.first], moving.boxes[at.first + 1], at.fraction, load_origin(ray),
                     Float4{1.0f, 1.0f, 1.0f, 1.0f} / load_direction(ray), enter, leave, margin);
}

// Takes a world ray into the space of an instance at a time; returns false if it cannot hit
// anything there.
[[gnu::always_inline]] inline bool enter_space(const Structure& s, const MovingInstance& moving, const Ray& world,
                                               float time, float t_min, float t_far, Ray& ray) {
  ray = world;
  if (!moving.keys.empty()) {
    const KeyInterval at = key_interval(time, static_cast<uint32_t>(moving.keys.size() - 1));
    if (!enters(moving, at, world, t_min, t_far, s.moving_level.margin(world.origin))) return false;
    RayToObject to_object;
    if (!to_object.set_inverse_of(between(moving.keys[at.first], moving.keys[at.first + 1], at.fraction))) return false;
    ray = to_object(world);
  } else if (!moving.in_place) {
    ray = moving.to_object(world);
  }
  return can_hit(ray);
}

// Returns f(tree, motion) for the tree of an instance at a time.
template <class F>
[[gnu::always_inline]] inline auto with_tree(const MovingInstance& moving, float time, const F& f) {
  if (moving.deforming == nullptr) return f(*moving.tree, Static());
  const DeformingSlice& slice = moving.deforming->slice_at(time);
  return f(slice.tree, Deforming{time, slice.slice.fraction_of(time)});
}

template <bool kAny>
[[gnu::flatten]] inline bool trace_one_moving(const Structure& s, const MovingInstance& moving, const Ray& world,
                                              float time, float t_min, float& t_far, Hit& hit) {
  Ray ray;
  if (!enter_space(s, moving, world, time, t_min, t_far, ray)) return false;
  return with_tree(moving, time, [&](const Tree& tree, auto motion) {
    const CandidateFilter filter{s.filter, world, tree, moving.instance};
    TreeHit in_tree;
    if (!trace_tree<kAny>(tree, motion, ray, t_min, filter, t_far, in_tree)) return false;
    if (kAny) return true;
    merge_hit(filter, in_tree, hit);
    return false;
  });
}

// Traces moving instances from a node of the hierarchy on. `world` satisfies can_hit(); `hit`, if
// any, is at t_far, which hits narrow.
template <bool kAny>
inline bool trace_moving_from(const Structure& s, uint32_t node, const Ray& world, float& t_far, Hit& hit) {
  const float t_min = std::max(world.t_min, 0.0f), time = clamped_time(world.time);
  const auto visit = [&](uint32_t i) {
    if (s.filter.abandoned()) [[unlikely]]
      return true;
    return trace_one_moving<kAny>(s, s.moving[i], world, time, t_min, t_far, hit);
  };
  return visit_instances<kAny>(s.moving_level, std::span(s.moving), world, t_min, t_far, visit, node);
}
template <bool kAny>
inline bool trace_moving(const Structure& s, const Ray& world, float t_far, Hit& hit) {
  return trace_moving_from<kAny>(s, 0, world, t_far, hit);
}

// Moving instances, for a stream.
struct MovingInstances {
  const Structure& structure;

  [[nodiscard]] const InstanceLevel& level() const { return structure.moving_level; }
  void fetch(uint32_t number) const {
    const auto* moving = reinterpret_cast<const std::byte*>(structure.moving.data() + number);
    prefetch(moving);
    prefetch(moving + sizeof(MovingInstance) - 1);
  }
  // Prefetches two keys, which are most often all; the interval of a ray is not known so early.
  void fetch_keys(uint32_t number) const {
    const MovingInstance& moving = structure.moving[number];
    prefetch(moving.boxes.data());
    prefetch(moving.keys.data());
    prefetch(moving.keys.data() + 1);
  }
  [[nodiscard]] Entered enter(uint32_t number, const Ray& world, float t_far, Ray& ray) const {
    const MovingInstance& moving = structure.moving[number];
    if (moving.deforming != nullptr) return {nullptr, moving.instance, true};
    Ray in_tree;
    if (!enter_space(structure, moving, world, clamped_time(world.time), std::max(world.t_min, 0.0f), t_far, in_tree))
      return {};
    ray = with_end(in_tree, t_far);
    return {moving.tree, moving.instance};
  }
  // The same for rays of a mask; returns a mask of those to be traced.
  uint32_t enter_all(uint32_t number, const LevelRays& rays, uint32_t active, Ray* inside, Entered& in) const {
    const MovingInstance& moving = structure.moving[number];
    in = {moving.tree, moving.instance, moving.deforming != nullptr};
    if (in.is_apart) return active;
    if (!moving.keys.empty()) return enter_moving(moving, rays, active, inside);
    for (uint32_t rest = active; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<size_t>(std::countr_zero(rest));
      const Ray world = with_end(*rays.ray[i], rays.lanes.t_max[i]);
      inside[i] = moving.in_place ? world : moving.to_object(world);
    }
    return active;
  }
};
// The calls of a stream through moving instances.
struct OfMoving {
  const Structure& s;
  std::span<const Ray> rays;

  template <bool kAny>
  bool trace_whole(size_t i, Hit& hit) const {
    return trace_moving<kAny>(s, rays[i], hit.is_hit() ? hit.t : rays[i].t_max, hit);
  }
  template <bool kAny>
  bool trace_one(size_t i, uint32_t number, float& t_far, Hit& hit) const {
    const float t_min = std::max(rays[i].t_min, 0.0f);
    return trace_one_moving<kAny>(s, s.moving[number], rays[i], clamped_time(rays[i].time), t_min, t_far, hit);
  }
  template <bool kAny>
  [[gnu::noinline]] bool visit(size_t i, uint32_t node, float& t_far, Hit& hit) const {
    return trace_moving_from<kAny>(s, node, rays[i], t_far, hit);
  }
};

template <bool kAny, class Answer>
[[gnu::noinline]] void stream_moving(const Structure& s, std::span<const Ray> rays, std::span<Answer> answers) {
  InstanceStream<kAny, MovingInstances> stream({s}, s.filter, nullptr);
  stream.trace(rays, BatchAnswers<kAny, OfMoving, Answer>{{s, rays}, answers});
}

template <class Answer>
inline void add_moving(const Structure& s, std::span<const Ray> rays, std::span<Answer> answers) {
  constexpr bool kAny = std::is_same_v<Answer, uint8_t>;
  if (rays.size() >= kMinStreamRays && s.moving_level.depth() <= TreesInTurn::kMaxDepth)
    return stream_moving<kAny>(s, rays, answers);
  const BatchAnswers<kAny, OfMoving, Answer> calls{{s, rays}, answers};
  for (size_t i = 0; i < rays.size(); ++i)
    if (calls.end_of(i) >= 0.0f && can_hit(rays[i])) calls.trace_alone(i);
}

template <const Queries& kStatic>
inline Hit intersect(const Structure& s, const Ray& ray) {
  Hit hit = kStatic.intersect(s, ray);
  if (can_hit(ray)) trace_moving<false>(s, ray, hit.is_hit() ? hit.t : ray.t_max, hit);
  return hit;
}
template <const Queries& kStatic>
inline bool occluded(const Structure& s, const Ray& ray) {
  Hit hit;
  return kStatic.occluded(s, ray) || (can_hit(ray) && trace_moving<true>(s, ray, ray.t_max, hit));
}

// Answers a batch query: static geometry first, then moving instances.
template <const Queries& kStatic, bool kCoherent, class Answer,
          void (*Queries::*query)(const Structure&, std::span<const Ray>, std::span<Answer>)>
inline void batch(const Structure& s, std::span<const Ray> rays, std::span<Answer> answers) {
  constexpr bool kAny = std::is_same_v<Answer, uint8_t>;
  (kStatic.*query)(s, rays, answers);
  if constexpr (kCoherent)
    trace_coherent_instances<kAny, OfMoving>(s, MovingInstances{s}, rays, answers);
  else
    add_moving(s, rays, answers);
}

template <const Queries& kStatic>
constexpr Queries make_moving_queries() {
  return {intersect<kStatic>,
          occluded<kStatic>,
          batch<kStatic, false, Hit, &Queries::intersect_stream>,
          batch<kStatic, false, uint8_t, &Queries::occluded_stream>,
          batch<kStatic, true, Hit, &Queries::intersect_coherent>,
          batch<kStatic, true, uint8_t, &Queries::occluded_coherent>};
}

} // namespace kindling::accel::kd::KINDLING_SIMD
