// Traces one ray through a tree, static or deforming.
//
// Robustness (tests/accel/test_watertight.cpp, test_oracle.cpp): hits must not depend on the tree,
// so a ray enters all cells in which a hit may lie whose triangle is there or near.
//  - A cell refers to all triangles within their margin of it (BuildMeshes). What remains are
//    errors relative to the distance: a box is entered if enter <= leave * kWiden.
//  - Distances are (face - origin) * (1 / direction), where the reciprocal is finite
//    (finite_reciprocal()): a ray that lies in a face is on one side of it.
//  - Hits in a leaf count up to the end of the ray, not of the cell. The search ends when the next
//    cell lies beyond the hit by more than these errors.
//  - In a deforming tree boxes have a margin for the rounding of motion (swept.h).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/box_clip.h"
#include "accel/kdtree/kernels/box_walk.h"

namespace kindling::accel::kd::KINDLING_SIMD {

inline bool clip_to_tree(const Tree& tree, Static, Float4 origin, Float4 reciprocal, float& enter, float& leave) {
  return clip_to_box(tree.clip_bounds, origin, reciprocal, enter, leave);
}
inline bool clip_to_tree(const Tree& tree, Deforming motion, Float4 origin, Float4 reciprocal, float& enter,
                         float& leave) {
  return clip_to_box(tree.clip_bounds, tree.clip_bounds_at_end, motion.fraction, origin, reciprocal, enter, leave,
                     0.0f);
}

// The walk of a ray that may_bend(). The test is copied, so that the caller keeps its own in
// registers.
template <bool kAny, class Motion, class Test>
[[gnu::noinline]] bool walk_bent(const Tree& tree, Motion motion, const Ray& ray, float t_min, const float& t_far,
                                 Test test) {
  const bool lengthens = is_short(ray.direction);
  const float length = lengthens ? kLengthen : 1.0f, unit = lengthens ? kShorten : 1.0f;
  const Imath::V3f direction = ray.direction * length;
  const Float4 reciprocal{kd::finite_reciprocal(direction.x), kd::finite_reciprocal(direction.y),
                          kd::finite_reciprocal(direction.z), 0.0f};
  float enter = t_min * unit, leave = t_far * unit;
  if (!clip_to_tree(tree, motion, load_origin(ray), reciprocal, enter, leave)) return false;
  const WalkingRay walking = walking_ray(ray, reciprocal, t_min * unit);
  float end = t_far * unit;
  return walk_boxes<kAny>(tree, motion, walking, tree.root, end, [&](const LeafUnit* leaf) {
    const bool ends = test(leaf, walking.shear);
    end = t_far * unit;
    return ends;
  });
}

// Takes a ray through a tree; it is in the tree's space and satisfies can_hit(). Calls test(leaf,
// shear) for the leaves that it enters up to t_far, at most the largest float, which the call may
// narrow, until it returns true, which is then the result. kAny: the first hit ends the ray.
template <bool kAny, class Motion, class Test>
[[gnu::always_inline]] inline bool walk_tree(const Tree& tree, Motion motion, const Ray& ray, float t_min,
                                             const float& t_far, const Test& test) {
  if (tree.root == kEmptyChild) return false;
  if (may_bend(ray.direction)) [[unlikely]]
    return walk_bent<kAny>(tree, motion, ray, t_min, t_far, test);
  float enter = t_min, leave = t_far;
  const Float4 reciprocal = Float4{1.0f, 1.0f, 1.0f, 1.0f} / load_direction(ray);
  if (!clip_to_tree(tree, motion, load_origin(ray), reciprocal, enter, leave)) return false;
  const WalkingRay walking = walking_ray(ray, reciprocal, t_min);
  return walk_boxes<kAny>(
      tree, motion, walking, tree.root,
      t_far, [&](const LeafUnit* unit) __attribute__((always_inline)) { return test(unit, walking.shear); });
}

// Traces a ray through a tree. `ray` is in the tree's space and satisfies can_hit(). Nearest hit:
// finds the hit in (t_min, t_far], and narrows t_far to it. Any hit: returns true at the first
// found.
template <bool kAny, class Motion>
inline bool trace_tree(const Tree& tree, Motion motion, const Ray& ray, float t_min, const CandidateFilter& filter,
                       float& t_far, TreeHit& best) {
  assert(can_hit(ray));
  t_far = std::min(t_far, std::numeric_limits<float>::max());
  const auto test = [&](const LeafUnit* unit, const RayShear& shear) __attribute__((always_inline)) {
    return intersect_leaf<kAny>(unit, motion, shear, t_min, filter, t_far, best);
  };
  return walk_tree<kAny>(tree, motion, ray, t_min, t_far, test) || (!kAny && best.is_hit());
}
template <bool kAny>
inline bool trace_tree(const Tree& tree, const Ray& ray, float t_min, const CandidateFilter& filter, float& t_far,
                       TreeHit& best) {
  return trace_tree<kAny>(tree, Static(), ray, t_min, filter, t_far, best);
}

// Traces ray `i` of a batch, in world space, on its own; it must satisfy can_hit(). Calls finish(i,
// hit) if it hits something.
template <bool kAny, class Finish>
[[gnu::noinline]] void trace_indexed(const Tree& tree, const HitFilter& hit_filter, std::span<const Ray> rays, size_t i,
                                     const Finish& finish) {
  TreeHit best;
  float t_far = rays[i].t_max;
  const CandidateFilter filter{hit_filter, rays[i], tree, kNoId};
  if (trace_tree<kAny>(tree, rays[i], std::max(rays[i].t_min, 0.0f), filter, t_far, best)) finish(i, best);
}

} // namespace kindling::accel::kd::KINDLING_SIMD
