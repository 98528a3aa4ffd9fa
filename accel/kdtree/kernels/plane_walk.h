// Traversal of a deforming tree by one ray: the planes of its nodes, at the time of the ray.
//
// The near child of a node is found from the point where the ray enters it: comparing that point
// with the seven planes gives seven bits, which a table maps to the lane. The intervals of all
// eight children follow from the distances of the planes off that critical path; those that the ray
// also enters stay in a frame of the stack, nearest first. If rounding has moved the point across a
// plane, intervals decide the order.
//
// Robustness (tests/accel/test_motion_kdtree.cpp): a ray enters all cells in which a hit may lie
// whose triangle is there or near.
//  - Planes have no margin as those of static trees do. An interval may be empty by a `slack`
//    besides, and rays with a component that is almost or exactly zero, for which that would be too
//    much, take a walk of their own where each plane has its margin: see is_steep().
//  - Distances are (plane - origin) * (1 / direction), where direction 0 gives infinities. 0 *
//    infinity is NaN and must impose no restriction, which the order of the operands of min and max
//    ensures; a ray in a plane visits both sides.
//  - Hits in a leaf count up to the end of the ray, not of the cell. The search ends when the next
//    cell lies beyond the hit by more than these errors, unless the ray is steep.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/box_clip.h"
#include "accel/kdtree/kernels/walking_ray.h"

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

// Returns true if a ray may lie in a plane or within its margin for long: some component of the
// direction is below 2^-10 of the largest. Such a ray has about the same interval on both sides of
// that plane. Nearer cells of one side may then be below cells of the other on the stack, so a cell
// beyond the hit is skipped and does not end the search.
inline bool is_steep(const Imath::V3f& direction) {
  const float x = std::fabs(direction.x), y = std::fabs(direction.y), z = std::fabs(direction.z);
  const float limit = std::max(std::max(std::max(x, y), z) * 0x1p-10f, std::numeric_limits<float>::min());
  return (x < limit) | (y < limit) | (z < limit);
}

// Returns the distance by which planes are wider for steep rays.
inline float margin_of(const Tree& tree) { return kExtentTolerance * tree.largest_extent; }

// The result of a step down: the child to visit next, which may be empty, and the end of its
// interval (it begins with the node's).
struct WideStep {
  ChildWord child;
  float leave;
  uint32_t rest; // bit i: child i of the frame is still to be visited
};

// Returns the plane positions of a node.
inline Lanes8 planes_of(const MovingNode& node, Deforming motion) {
  return Lanes8::load(node.planes.data()) + Lanes8::load(node.displacements.data()) * Lanes8(motion.fraction);
}

// Sets the children of a node in the order of the ray, given the distances to its planes as begins
// and ends of intervals. Bit i of the result is set if the ray enters child i of that order, be it
// empty or not.
template <class Enters>
[[gnu::always_inline]] inline uint32_t set_frame(const MovingNode& node, IntLanes8 order, Lanes8 begin, Lanes8 end,
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
// `slack`: see walk_planes().
[[gnu::always_inline]] inline WideStep step_down(const MovingNode& node, Lanes8 planes, Lanes8 origin,
                                                 Lanes8 reciprocal, Lanes8 point, float enter, float leave, float slack,
                                                 TraversalStack::Frame& frame) {
  const IntLanes8 axes = shift_by_lane(IntLanes8(std::bit_cast<uint32_t>(node.planes[kAxesLane])));
  const uint32_t near = tables::kNearLane[at_least(permute(point, axes), planes)];

  const Lanes8 axis_reciprocal = permute(reciprocal, axes);
  const Lanes8 t = (planes - permute(origin, axes)) * axis_reciprocal;
  const IntLanes8 order = IntLanes8::from_bytes(tables::kNearFirst[sign_bits(axis_reciprocal)]);
  const uint32_t reached = set_frame(
      node, order, t, t, enter, leave,
      [&](Lanes8 en, Lanes8 ex) { return at_most(en, ex * Lanes8(kWiden) + Lanes8(slack)); }, frame);
  const uint32_t near_bit = low_bits_equal(order, near);
  const uint32_t entered = reached & nonzero_bits(IntLanes8::load(frame.child.data()));
  // The point may lie within the tolerance of a plane. Then a child before the near one is reached
  // too and must come first, or a hit behind it would end the search; or, by rounding, the near one
  // is not reached at all. Intervals decide.
  if ((reached & (0U - reached)) != near_bit) [[unlikely]]
    return {kEmptyChild, leave, entered};
  return {node.child[near], frame.leave[static_cast<size_t>(std::countr_zero(near_bit))], entered & ~near_bit};
}

// The same for a steep ray: planes have a margin on both sides, and intervals alone decide.
inline WideStep step_down_steep(const MovingNode& node, Lanes8 planes, Lanes8 origin, Lanes8 reciprocal, float enter,
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

// Takes a ray through a deforming tree, with interval [enter, leave] in its box. Calls test(leaf)
// for the leaves that it enters up to t_far, which the call may narrow, until it returns true,
// which is then the result. kAny: the first hit ends the ray. `slack`: the margin of planes on both
// sides, along a ray that is not steep.
template <bool kAny, bool kSteepRay, class Test>
[[gnu::always_inline]] inline bool walk_planes(const Tree& tree, Deforming motion, float slack, const WalkingRay& ray,
                                               float enter, float leave, const float& t_far, const Test& test) {
  const auto* vectors = reinterpret_cast<const float*>(&ray.ray); // lane 3 of each is never selected
  const Lanes8 origin = Lanes8::load_twice(vectors);
  const Lanes8 direction = Lanes8::load_twice(vectors + 4);
  const Lanes8 margin(margin_of(tree)); // of steep rays

  TraversalStack stack;
  ChildWord child = tree.root;
  size_t top = 0; // the current frame; its `rest` is held in a register
  uint32_t rest = 1;
  stack.frames[0].enter[0] = std::numeric_limits<float>::quiet_NaN(); // ends the loop below
  Lanes8 point = origin + Lanes8(enter) * direction;
  while (true) {
    while (static_cast<int32_t>(child) > 0) {
      stack.rest[top] = rest;
      top += static_cast<size_t>(rest != 0);
      assert(top < TraversalStack::kFrames);
      const MovingNode& node = tree.moving_nodes[child];
      const Lanes8 planes = planes_of(node, motion);
      WideStep step;
      if constexpr (kSteepRay)
        step = step_down_steep(node, planes, origin, ray.reciprocal, enter, leave, margin, stack.frames[top]);
      else
        step = step_down(node, planes, origin, ray.reciprocal, point, enter, leave, slack, stack.frames[top]);
      child = step.child;
      leave = step.leave;
      rest = step.rest;
      // Prefetches the next cell, or an unneeded one if there is none. Any-hit rays often end
      // before they need it.
      if (!kAny)
        prefetch_child(tree, tree.moving_nodes,
                       stack.frames[top].child[static_cast<size_t>(std::countr_zero(rest)) % kWideLanes]);
    }
    if (child != kEmptyChild) {
      const LeafUnit* unit = tree.leaves.data() + (child & ~kLeafBit);
      if (test(unit)) return true;
    }
    const float end = t_far * kBeyond + (kSteepRay ? 0.0f : 2.0f * slack);
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

// The test is copied, so that the caller keeps its own in registers.
template <bool kAny, class Test>
[[gnu::noinline]] bool walk_steep(const Tree& tree, Deforming motion, const WalkingRay& ray, float enter, float leave,
                                  const float& t_far, Test test) {
  return walk_planes<kAny, true>(tree, motion, 0.0f, ray, enter, leave, t_far, test);
}

// See the version for static trees (traversal.h).
template <bool kAny, class Test>
[[gnu::always_inline]] inline bool walk_tree(const Tree& tree, Deforming motion, const Ray& ray, float t_min,
                                             const float& t_far, const Test& test) {
  float enter = t_min, leave = t_far;
  const Float4 reciprocal = Float4{1.0f, 1.0f, 1.0f, 1.0f} / load_direction(ray);
  const float margin = margin_of(tree);
  if (!clip_to_box(tree.clip_bounds, tree.clip_bounds_at_end, motion.fraction, load_origin(ray), reciprocal, enter,
                   leave, margin))
    return false;
  const WalkingRay walking = walking_ray(ray, reciprocal, t_min);
  const auto test_leaf = [&](const LeafUnit* unit) __attribute__((always_inline)) { return test(unit, walking.shear); };
  if (is_steep(ray.direction)) return walk_steep<kAny>(tree, motion, walking, enter, leave, t_far, test_leaf);
  const float largest =
      std::max(std::max(std::fabs(reciprocal[0]), std::fabs(reciprocal[1])), std::fabs(reciprocal[2]));
  return walk_planes<kAny, false>(tree, motion, 2.0f * margin * largest, walking, enter, leave, t_far, test_leaf);
}

} // namespace kindling::accel::kd::KINDLING_SIMD
