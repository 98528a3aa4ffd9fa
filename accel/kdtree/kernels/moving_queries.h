// The queries of a structure in which something moves: those of what stands still, which know nothing of time, and behind them, ray
// by ray, what moves. Structures without motion never come here.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/structure_queries.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Ties go to the smallest ids.
inline bool comes_before(const Hit& a, const Hit& b) {
  if (a.instance != b.instance) return a.instance < b.instance;
  return a.mesh != b.mesh ? a.mesh < b.mesh : a.triangle < b.triangle;
}

template <bool kAny>
inline bool trace_one_moving(const Structure& s, const MovingInstance& moving, const Ray& world, float time,
                             float t_min, float& t_far, Hit& hit) {
  Ray ray = world;
  if (!moving.keys.empty()) {
    RayToObject to_object;
    if (!to_object.set_inverse_of(matrix_at(moving.keys, time))) return false;
    ray = to_object(world);
  } else if (!moving.in_place) {
    ray = moving.to_object(world);
  }
  if (!can_hit(ray)) return false;
  const DeformingSlice* slice = moving.deforming == nullptr ? nullptr : &moving.deforming->slice_at(time);
  const Tree& tree = slice == nullptr ? *moving.tree : slice->tree;
  const CandidateFilter filter{s.filter, world, tree, moving.instance};
  TreeHit in_tree;
  const bool found_any = slice == nullptr ? trace_tree<kAny>(tree, ray, t_min, filter, t_far, in_tree)
                                          : trace_tree<kAny>(tree, ray, t_min, filter, t_far, in_tree,
                                                             Deforming{time, slice->slice.fraction_of(time)});
  if (!found_any) return false;
  if (kAny) return true;
  const Hit found = filter.resolve(in_tree);
  if (!hit.is_hit() || found.t != hit.t || comes_before(found, hit)) hit = found;
  return false;
}

// `world` passed can_hit(); `hit`, if any, lies at t_far.
template <bool kAny>
inline bool trace_moving(const Structure& s, const Ray& world, float t_far, Hit& hit) {
  const float t_min = std::max(world.t_min, 0.0f), time = clamped_time(world.time);
  return visit_instances(s.moving_level, world, t_min, t_far, [&](uint32_t i) {
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

inline Hit intersect_all(const Structure& s, const Ray& ray) {
  Hit hit;
  if (!can_hit(ray)) return hit;
  trace<false>(s, ray, hit);
  trace_moving<false>(s, ray, hit.is_hit() ? hit.t : ray.t_max, hit);
  return hit;
}
inline bool occluded_by_any(const Structure& s, const Ray& ray) {
  Hit hit;
  return can_hit(ray) && (trace<true>(s, ray, hit) || trace_moving<true>(s, ray, ray.t_max, hit));
}

// A batch query of what stands still, and then what moves.
template <class Answer, void (*still)(const Structure&, std::span<const Ray>, std::span<Answer>)>
inline void with_moving(const Structure& s, std::span<const Ray> rays, std::span<Answer> answers) {
  still(s, rays, answers);
  add_moving(s, rays, answers);
}

constexpr Queries make_moving_queries() {
  return {intersect_all,
          occluded_by_any,
          with_moving<Hit, intersect_stream>,
          with_moving<uint8_t, occluded_stream>,
          with_moving<Hit, intersect_coherent>,
          with_moving<uint8_t, occluded_coherent>};
}

} // namespace kindling::accel::kd::KINDLING_SIMD
