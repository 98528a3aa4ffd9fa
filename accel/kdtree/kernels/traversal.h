// Single-ray traversal of a tree, by the boxes of its nodes or by planes.
//
// Rays that are not steep walk static trees by boxes (box_walk.h); the others, and all rays through
// deforming trees, by the planes of wide nodes.
//
// The near child of a node is found from the point where the ray enters it: comparing that point
// with the seven planes gives seven bits, which a table maps to the lane. The intervals of all
// eight children follow from the distances of the planes off that critical path; those that the ray
// also enters stay in a frame of the stack, nearest first. If rounding has moved the point across a
// plane, intervals decide the order.
//
// Robustness (tests/accel/test_watertight.cpp, test_oracle.cpp): hits must not depend on the tree,
// so a ray enters all cells in which a hit may lie whose triangle is there or near.
//  - A cell of a static tree refers to all triangles within their margin of it (BuildMeshes). What
//    remains are errors relative to the distance: a cell is entered if enter <= leave * kWiden.
//  - The planes of a deforming tree have no such margin. There an interval may be empty by a
//    `slack` besides, and rays with a component that is almost or exactly zero, for which that
//    would be too much, take a walk of their own where each plane has its margin: see is_steep().
//  - Distances are (plane - origin) * (1 / direction), where direction 0 gives infinities. 0 *
//    infinity is NaN and must impose no restriction, which the order of the operands of min and max
//    ensures; a ray in a plane visits both sides.
//  - Hits in a leaf count up to the end of the ray, not of the cell. The search ends when the next
//    cell lies beyond the hit by more than these errors, unless the ray is steep.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/box_walk.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Cells still to visit. Each node on the path that has any leaves a frame; the bits of `rest` mark
// these children. Nearer ones come first, except for steep rays. A frame is written whole and
// aligned: packing its cells would cost more.
struct TraversalStack {
  struct alignas(32) Frame {
    std::array<float, kWideLanes> enter, leave;
    std::array<ChildWord, kWideLanes> child;
  };
  static constexpr size_t kFrames = kMaxWideDepth + 1; // the lowest frame ends the ray
  std::array<Frame, kFrames> frames;
  std::array<uint32_t, kFrames> rest;
};

// Returns true if the ray may lie in a plane of the tree, because some 1 / direction is infinite.
// Such a ray has the same interval on both sides of that plane. Nearer cells of one side may then
// be below cells of the other on the stack, so a cell beyond the hit is skipped and does not end
// the search.
inline bool may_lie_in_plane(const Imath::V3f& direction) {
  constexpr float kMin = std::numeric_limits<float>::min();
  return (std::fabs(direction.x) < kMin) | (std::fabs(direction.y) < kMin) | (std::fabs(direction.z) < kMin);
}

// Returns true if a ray may lie in a plane or, in a deforming tree, within the margin of one for
// long: some component of the direction is below 2^-10 of the largest.
inline bool is_steep(const Imath::V3f& direction, Static) { return may_lie_in_plane(direction); }
inline bool is_steep(const Imath::V3f& direction, Deforming) {
  const float x = std::fabs(direction.x), y = std::fabs(direction.y), z = std::fabs(direction.z);
  const float limit = std::max(std::max(x, y), z) * 0x1p-10f;
  return may_lie_in_plane(direction) | (x < limit) | (y < limit) | (z < limit);
}

// Returns the distance by which planes are wider for steep rays.
inline float margin_of(const Tree&, Static) { return 0.0f; }
inline float margin_of(const Tree& tree, Deforming) { return kExtentTolerance * tree.largest_extent; }

// These widen the end of a cell's interval, and the end of a ray. In a static tree the widening is
// relative to the distance.
struct Relative {
  [[nodiscard]] Lanes8 widen(Lanes8 leave) const { return leave * Lanes8(kWiden); }
  [[nodiscard]] float end(float t_far) const { return t_far * kBeyond; }
};
// In a deforming tree the margin of its planes is added.
struct RelativeAndSlack {
  float slack; // that of a ray that is not steep: the margin on both sides, along the ray
  [[nodiscard]] Lanes8 widen(Lanes8 leave) const { return leave * Lanes8(kWiden) + Lanes8(slack); }
  [[nodiscard]] float end(float t_far) const { return t_far * kBeyond + 2.0f * slack; }
};
inline Relative ends_of(const Tree&, Static, Float4) { return {}; }
inline RelativeAndSlack ends_of(const Tree& tree, Deforming motion, Float4 reciprocal) {
  const float largest =
      std::max(std::max(std::fabs(reciprocal[0]), std::fabs(reciprocal[1])), std::fabs(reciprocal[2]));
  return {2.0f * margin_of(tree, motion) * largest};
}

// Clips [enter, leave] to the box, which `margin` widens; returns false if nothing is left. Free of
// branches: the signs of mixed rays cannot be predicted.
inline bool clip_to_box(const Imath::Box3f& box, Float4 origin, Float4 reciprocal, float& enter, float& leave,
                        float margin = 0.0f) {
  Float4 low, high; // lanes x, y, z
  std::memcpy(&low, reinterpret_cast<const float*>(&box), sizeof(Float4));
  std::memcpy(&high, reinterpret_cast<const float*>(&box) + 2, sizeof(Float4));
  high = __builtin_shufflevector(high, high, 1, 2, 3, 3);
  low = ((low - origin) - margin) * reciprocal;
  high = ((high - origin) + margin) * reciprocal;
  const Int4 down = std::bit_cast<Int4>(reciprocal) < 0;
  const Float4 first{enter, enter, enter, enter}, last{leave, leave, leave, leave};
  Float4 near = down ? high : low, far = down ? low : high;
  near = near > first ? near : first; // NaN imposes no restriction
  far = far < last ? far : last;
  leave = std::min(std::min(far[0], far[1]), far[2]);
  const float entry = std::max(std::max(near[0], near[1]), near[2]);
  enter = std::min(entry, leave); // never beyond the end of the ray
  return entry <= leave * kWiden;
}

// Clips to a box that moves from one place to another, with all faces along straight lines.
inline bool clip_to_box(const Imath::Box3f& from, const Imath::Box3f& to, float fraction, Float4 origin,
                        Float4 reciprocal, float& enter, float& leave, float margin) {
  struct Faces {
    Float4 first, last; // min.x to max.x, min.z to max.z
  };
  alignas(16) Imath::Box3f box;
  Faces a, b;
  const auto load = [](const Imath::Box3f& faces, Faces& out) {
    std::memcpy(&out.first, reinterpret_cast<const float*>(&faces), sizeof(Float4));
    std::memcpy(&out.last, reinterpret_cast<const float*>(&faces) + 2, sizeof(Float4));
  };
  load(from, a);
  load(to, b);
  a.first = a.first + (b.first - a.first) * fraction;
  a.last = a.last + (b.last - a.last) * fraction;
  std::memcpy(reinterpret_cast<float*>(&box), &a.first, sizeof(Float4));
  std::memcpy(reinterpret_cast<float*>(&box) + 2, &a.last, sizeof(Float4));
  return clip_to_box(box, origin, reciprocal, enter, leave, margin);
}

// The result of a step down: the child to visit next, which may be empty, and the end of its
// interval (it begins with the node's).
struct WideStep {
  ChildWord child;
  float leave;
  uint32_t rest; // bit i: child i of the frame is still to be visited
};

// Returns the plane positions of a node.
inline Lanes8 planes_of(const Tree& tree, ChildWord node, Static) {
  return Lanes8::load(tree.nodes[node].planes.data());
}
inline Lanes8 planes_of(const Tree& tree, ChildWord node, Deforming motion) {
  return Lanes8::load(tree.nodes[node].planes.data()) +
         Lanes8::load(tree.displacements[node].lanes.data()) * Lanes8(motion.fraction);
}

// Sets the children of a node in the order of the ray, given the distances to its planes as begins
// and ends of intervals. Bit i of the result is set if the ray enters child i of that order, be it
// empty or not.
template <class Enters>
[[gnu::always_inline]] inline uint32_t set_frame(const WideNode& node, IntLanes8 order, Lanes8 begin, Lanes8 end,
                                                 float enter, float leave, const Enters& enters,
                                                 TraversalStack::Frame& frame) {
  const IntLanes8 second = shift_right<6>(order), third = shift_right<3>(order);
  // In this order lanes 4 to 7 are on the far side of the root's plane, and so on.
  const Lanes8 en = max_where<0xaa>(
      max_where<0xcc>(max_where<0xf0>(Lanes8(enter), broadcast_lane<kRootLane>(begin)), permute(begin, second)),
      permute(begin, third));
  const Lanes8 ex = min_where<0x55>(
      min_where<0x33>(min_where<0x0f>(Lanes8(leave), broadcast_lane<kRootLane>(end)), permute(end, second)),
      permute(end, third));
  en.store(frame.enter.data());
  ex.store(frame.leave.data());
  permute(IntLanes8::load(node.child.data()), order).store(frame.child.data());
  return enters(en, ex);
}

// Steps from a node, entered at `point` for [enter, leave], to its near child; the frame receives
// all children in the order of the ray. Ray vectors are {x, y, z, *, x, y, z, *}.
template <class Ends>
[[gnu::always_inline]] inline WideStep step_down(const WideNode& node, Lanes8 planes, Lanes8 origin, Lanes8 reciprocal,
                                                 Lanes8 point, float enter, float leave, Ends ends,
                                                 TraversalStack::Frame& frame) {
  const IntLanes8 axes = shift_by_lane(IntLanes8(std::bit_cast<uint32_t>(node.planes[kAxesLane])));
  const uint32_t near = tables::kNearLane[at_least(permute(point, axes), planes)];

  const Lanes8 axis_reciprocal = permute(reciprocal, axes);
  const Lanes8 t = (planes - permute(origin, axes)) * axis_reciprocal;
  const IntLanes8 order = IntLanes8::from_bytes(tables::kNearFirst[sign_bits(axis_reciprocal)]);
  const uint32_t reached = set_frame(
      node, order, t, t, enter, leave, [&](Lanes8 en, Lanes8 ex) { return at_most(en, ends.widen(ex)); }, frame);
  const uint32_t near_bit = low_bits_equal(order, near);
  const uint32_t entered = reached & nonzero_bits(IntLanes8::load(frame.child.data()));
  // The point may lie within the tolerance of a plane. Then a child before the near one is reached
  // too and must come first, or a hit behind it would end the search; or, by rounding, the near one
  // is not reached at all. Intervals decide, as in a stream.
  if ((reached & (0U - reached)) != near_bit) [[unlikely]]
    return {kEmptyChild, leave, entered};
  return {node.child[near], frame.leave[static_cast<size_t>(std::countr_zero(near_bit))], entered & ~near_bit};
}

// The same for a steep ray: planes have a margin on both sides, and intervals alone decide.
inline WideStep step_down_steep(const WideNode& node, Lanes8 planes, Lanes8 origin, Lanes8 reciprocal, float enter,
                                float leave, Lanes8 margin, TraversalStack::Frame& frame) {
  const IntLanes8 axes = shift_by_lane(IntLanes8(std::bit_cast<uint32_t>(node.planes[kAxesLane])));
  const Lanes8 axis_reciprocal = permute(reciprocal, axes), wide = with_sign_of(margin, axis_reciprocal);
  const Lanes8 distance = planes - permute(origin, axes);
  const IntLanes8 order = IntLanes8::from_bytes(tables::kNearFirst[sign_bits(axis_reciprocal)]);
  // 0 * infinity is NaN and imposes no restriction.
  const uint32_t reached = set_frame(
      node, order, (distance - wide) * axis_reciprocal, (distance + wide) * axis_reciprocal, enter, leave,
      [](Lanes8 en, Lanes8 ex) { return at_most(en, ex * Lanes8(kWiden)); }, frame);
  return {kEmptyChild, leave, reached & nonzero_bits(IntLanes8::load(frame.child.data()))};
}

// Takes a ray through the cell `child` of a tree, with interval [enter, leave] there. Calls
// test(leaf) for the leaves that it enters up to t_far, which the call may narrow, until it returns
// true, which is then the result. kAny: the first hit ends the ray.
template <bool kAny, bool kSteepRay, class Motion, class Ends, class Test>
[[gnu::always_inline]] inline bool walk_cell(const Tree& tree, Motion motion, Ends ends, const WalkingRay& ray,
                                             ChildWord child, float enter, float leave, const float& t_far,
                                             const Test& test) {
  const auto* vectors = reinterpret_cast<const float*>(&ray.ray); // lane 3 of each is never selected
  const Lanes8 origin = Lanes8::load_twice(vectors);
  const Lanes8 direction = Lanes8::load_twice(vectors + 4);
  const Lanes8 margin(margin_of(tree, motion)); // of steep rays

  TraversalStack stack;
  size_t top = 0; // the current frame; its `rest` is held in a register
  uint32_t rest = 1;
  stack.frames[0].enter[0] = std::numeric_limits<float>::quiet_NaN(); // ends the loop below
  Lanes8 point = origin + Lanes8(enter) * direction;
  while (true) {
    while (static_cast<int32_t>(child) > 0) {
      stack.rest[top] = rest;
      top += static_cast<size_t>(rest != 0);
      assert(top < TraversalStack::kFrames);
      const WideNode& node = tree.nodes[child];
      const Lanes8 planes = planes_of(tree, child, motion);
      WideStep step;
      if constexpr (kSteepRay)
        step = step_down_steep(node, planes, origin, ray.reciprocal, enter, leave, margin, stack.frames[top]);
      else
        step = step_down(node, planes, origin, ray.reciprocal, point, enter, leave, ends, stack.frames[top]);
      child = step.child;
      leave = step.leave;
      rest = step.rest;
      // Prefetches the next cell, or an unneeded one if there is none. Any-hit rays often end
      // before they need it.
      if (!kAny)
        prefetch_child(tree, tree.nodes,
                       stack.frames[top].child[static_cast<size_t>(std::countr_zero(rest)) % kWideLanes]);
    }
    if (child != kEmptyChild) {
      const LeafUnit* unit = tree.leaves.data() + (child & ~kLeafBit);
      if (test(unit)) return true;
    }
    const float end = kSteepRay ? t_far * kBeyond : ends.end(t_far);
    do {
      // A branch on purpose: if predicted, the next cell does not wait for the intervals of the
      // last node.
      if (rest == 0) rest = stack.rest[--top];
      const auto next = static_cast<size_t>(std::countr_zero(rest));
      const TraversalStack::Frame& frame = stack.frames[top];
      child = frame.child[next];
      enter = frame.enter[next];
      leave = frame.leave[next];
      rest &= rest - 1;
      // A steep ray may have about the same interval on both sides of a plane. Nearer cells of one
      // side may then be below cells of the other, so a cell beyond the hit does not end the
      // search.
    } while (kSteepRay && enter > end);
    if (!(enter <= end)) return false;
    leave = leave < end ? leave : end;
    point = origin + Lanes8(enter) * direction;
  }
}

// Traces a ray through a cell. Nearest hit: finds the hit in (t_min, t_far], and narrows t_far to
// it. Any hit: returns true at the first found.
template <bool kAny, bool kSteepRay, class Motion, class Ends>
[[gnu::always_inline]] inline bool trace_in_cell(const Tree& tree, Motion motion, Ends ends, const WalkingRay& ray,
                                                 ChildWord child, float enter, float leave,
                                                 const CandidateFilter& filter, float& t_far, TreeHit& best) {
  const auto test = [&](const LeafUnit* unit) __attribute__((always_inline)) {
    return intersect_leaf<kAny>(unit, motion, ray.shear, ray.t_min, filter, t_far, best);
  };
  return walk_cell<kAny, kSteepRay>(tree, motion, ends, ray, child, enter, leave, t_far, test);
}

// Version for static trees and rays that are not steep.
template <bool kAny>
inline bool trace_cell(const Tree& tree, const WalkingRay& ray, ChildWord child, float enter, float leave,
                       const CandidateFilter& filter, float& t_far, TreeHit& best) {
  return trace_in_cell<kAny, false>(tree, Static(), Relative(), ray, child, enter, leave, filter, t_far, best);
}

// Version for whole trees and steep rays.
template <bool kAny, class Motion>
[[gnu::noinline]] bool trace_steep(const Tree& tree, Motion motion, const WalkingRay& ray, float enter, float leave,
                                   const CandidateFilter& filter, float& t_far, TreeHit& best) {
  return trace_in_cell<kAny, true>(tree, motion, Relative(), ray, tree.root, enter, leave, filter, t_far, best);
}

// Versions for whole trees and rays that are not steep.
template <bool kAny>
[[gnu::always_inline]] inline bool trace_whole(const Tree& tree, Static motion, const WalkingRay& ray,
                                               Float4 /*reciprocal*/, float /*enter*/, float /*leave*/,
                                               const CandidateFilter& filter, float& t_far, TreeHit& best) {
  const auto test = [&](const LeafUnit* unit) __attribute__((always_inline)) {
    return intersect_leaf<kAny>(unit, motion, ray.shear, ray.t_min, filter, t_far, best);
  };
  return walk_boxes<kAny>(tree, ray, t_far, test);
}
template <bool kAny>
[[gnu::always_inline]] inline bool trace_whole(const Tree& tree, Deforming motion, const WalkingRay& ray,
                                               Float4 reciprocal, float enter, float leave,
                                               const CandidateFilter& filter, float& t_far, TreeHit& best) {
  return trace_in_cell<kAny, false>(tree, motion, ends_of(tree, motion, reciprocal), ray, tree.root, enter, leave,
                                    filter, t_far, best);
}

// Traces a ray through a tree, with interval [enter, leave] in the tree's box; else as
// trace_tree().
template <bool kAny, class Motion>
[[gnu::always_inline]] inline bool trace_clipped(const Tree& tree, Motion motion, const Ray& ray, Float4 reciprocal,
                                                 float t_min, float enter, float leave, const CandidateFilter& filter,
                                                 float& t_far, TreeHit& best) {
  const WalkingRay walking = walking_ray(ray, reciprocal, t_min);
  const bool any = is_steep(ray.direction, motion)
                       ? trace_steep<kAny>(tree, motion, walking, enter, leave, filter, t_far, best)
                       : trace_whole<kAny>(tree, motion, walking, reciprocal, enter, leave, filter, t_far, best);
  return any || (!kAny && best.is_hit());
}

// Clips [enter, leave] to the box of a tree; returns false if nothing is left.
inline bool clip_to_tree(const Tree& tree, Static, Float4 origin, Float4 reciprocal, float& enter, float& leave) {
  return tree.root != kEmptyChild && clip_to_box(tree.clip_bounds, origin, reciprocal, enter, leave);
}
inline bool clip_to_tree(const Tree& tree, Deforming motion, Float4 origin, Float4 reciprocal, float& enter,
                         float& leave) {
  return clip_to_box(tree.clip_bounds, tree.clip_bounds_at_end, motion.fraction, origin, reciprocal, enter, leave,
                     margin_of(tree, motion));
}

// Traces a ray through a tree. `ray` is in the tree's space and satisfies can_hit(). Nearest hit:
// finds the hit in (t_min, t_far], and narrows t_far to it. Any hit: returns true at the first
// found.
template <bool kAny, class Motion>
inline bool trace_tree(const Tree& tree, Motion motion, const Ray& ray, float t_min, const CandidateFilter& filter,
                       float& t_far, TreeHit& best) {
  assert(can_hit(ray));
  t_far = std::min(t_far, std::numeric_limits<float>::max());
  float enter = t_min, leave = t_far;
  const Float4 reciprocal = Float4{1.0f, 1.0f, 1.0f, 1.0f} / load_direction(ray);
  if (!clip_to_tree(tree, motion, load_origin(ray), reciprocal, enter, leave)) return false;
  return trace_clipped<kAny>(tree, motion, ray, reciprocal, t_min, enter, leave, filter, t_far, best);
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
