// Queries for scenes with moving or deforming instances.
// The queries without motion run first and know nothing of time; moving instances are then traced
// ray by ray. Scenes without motion never use this code. It is compiled separately, so that the
// other queries stay unchanged.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/instances.h"
#include "accel/kdtree/kernels/plane_walk.h"
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
    const Hit found = filter.resolve(in_tree);
    if (!hit.is_hit() || found.t != hit.t || comes_before(found, hit)) hit = found;
    return false;
  });
}

// Traces all moving instances. `world` satisfies can_hit(); `hit`, if any, is at t_far.
template <bool kAny>
inline bool trace_moving(const Structure& s, const Ray& world, float t_far, Hit& hit) {
  const float t_min = std::max(world.t_min, 0.0f), time = clamped_time(world.time);
  return visit_instances<kAny>(s.moving_level, std::span(s.moving), world, t_min, t_far, [&](uint32_t i) {
    if (s.filter.abandoned()) [[unlikely]]
      return true;
    return trace_one_moving<kAny>(s, s.moving[i], world, time, t_min, t_far, hit);
  });
}

inline void add_moving(const Structure& s, std::span<const Ray> rays, std::span<Hit> hits) {
  for (size_t i = 0; i < rays.size(); ++i)
    if (can_hit(rays[i])) trace_moving<false>(s, rays[i], hits[i].is_hit() ? hits[i].t : rays[i].t_max, hits[i]);
}
inline void add_moving(const Structure& s, std::span<const Ray> rays, std::span<uint8_t> blocked) {
  for (size_t i = 0; i < rays.size(); ++i) {
    Hit hit;
    if (blocked[i] == 0 && can_hit(rays[i])) blocked[i] = trace_moving<true>(s, rays[i], rays[i].t_max, hit) ? 1 : 0;
  }
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
template <const Queries& kStatic, class Answer,
          void (*Queries::*query)(const Structure&, std::span<const Ray>, std::span<Answer>)>
inline void batch(const Structure& s, std::span<const Ray> rays, std::span<Answer> answers) {
  (kStatic.*query)(s, rays, answers);
  add_moving(s, rays, answers);
}

template <const Queries& kStatic>
constexpr Queries make_moving_queries() {
  return {intersect<kStatic>,
          occluded<kStatic>,
          batch<kStatic, Hit, &Queries::intersect_stream>,
          batch<kStatic, uint8_t, &Queries::occluded_stream>,
          batch<kStatic, Hit, &Queries::intersect_coherent>,
          batch<kStatic, uint8_t, &Queries::occluded_coherent>};
}

} // namespace kindling::accel::kd::KINDLING_SIMD
