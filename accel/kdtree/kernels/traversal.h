// One ray through a tree of wide nodes.
//
// The near child of a node is found from the point where the ray enters it: comparing that point with the seven planes gives
// seven bits, and a table turns them into the lane. The intervals of all eight children follow from the distances of the planes
// off that critical path; those that the ray also enters go to the stack, farthest first. Where rounding has taken the point across a
// plane, intervals decide the order.
//
// Robustness (tests/accel/test_watertight.cpp):
//  - distances are (plane - origin) * (1 / direction), where direction 0 gives infinities; 0 * infinity is NaN and must mean
//    "no restriction", which the order of the operands of min and max ensures; a ray in a plane visits both sides;
//  - a child is entered if its interval is empty by no more than rounding: enter <= leave * (1 + 4 ulp);
//  - hits in a leaf count up to the end of the ray, not of the cell; the search ends when the next cell lies behind the hit, unless
//    the ray may lie in a plane: see may_lie_in_plane().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/leaf_test.h"
#include "accel/kdtree/kernels/simd.h"

namespace kindling::accel::kd::KINDLING_SIMD {

inline constexpr float kWiden = 1.0f + 5e-7f; // a little over 4 ulp

// At most 7 pushes per three binary levels, and one more round; a compressed store may write 8 entries past the top.
inline constexpr size_t kStackSize = 7 * ((kMaxDepth + 2) / 3 + 1) + 9;

// Cells still to visit: nearer ones on top, but for rays that may_lie_in_plane().
struct TraversalStack {
  std::array<ChildWord, kStackSize> child;
  std::array<float, kStackSize> enter, leave;
};

// Whether the ray may lie in a plane of the tree: some 1 / direction is infinite. It then has both sides of that plane for one and
// the same interval, so that below the cells of one side, on the stack, stand nearer ones of the other: a cell beyond the hit is
// passed over, and does not end the search.
inline bool may_lie_in_plane(const Imath::V3f& direction) {
  constexpr float kLeast = std::numeric_limits<float>::min();
  return (std::fabs(direction.x) < kLeast) | (std::fabs(direction.y) < kLeast) | (std::fabs(direction.z) < kLeast);
}

// Cuts [enter, leave] to the box; false if nothing is left.
inline bool clip_to_box(const Imath::Box3f& box, const Imath::V3f& origin, const Imath::V3f& direction, float& enter,
                        float& leave) {
  for (int k = 0; k < 3; ++k) {
    const float reciprocal = 1.0f / direction[k];
    const bool down = std::signbit(direction[k]);
    const float t0 = ((down ? box.max[k] : box.min[k]) - origin[k]) * reciprocal;
    const float t1 = ((down ? box.min[k] : box.max[k]) - origin[k]) * reciprocal;
    enter = t0 > enter ? t0 : enter; // NaN: no restriction
    leave = t1 < leave ? t1 : leave;
  }
  const bool enters = enter <= leave * kWiden;
  enter = enter < leave ? enter : leave; // never beyond the end of the ray
  return enters;
}

// Outcome of a step down: the child to visit next, which may be empty, and where its interval ends (it begins with the node's).
struct WideStep {
  ChildWord child;
  float leave;
  uint32_t pushed; // other children that went to the stack, from `top` on, farthest first
};

// From a node, entered at `point` for [enter, leave], to its near child. Ray quantities are {x, y, z, *, x, y, z, *}.
inline WideStep step_down(const WideNode& node, Float8 origin, Float8 reciprocal, Float8 point, float enter,
                          float leave, TraversalStack& stack, size_t top) {
  const Float8 planes = Float8::load(node.planes.data());
  const Int8 axes = shift_by_lane(Int8(std::bit_cast<uint32_t>(node.planes[kAxesLane])));
  const uint32_t near = tables::kNearLane[at_least(permute(point, axes), planes)];

  const Float8 axis_reciprocal = permute(reciprocal, axes);
  const Float8 t = (planes - permute(origin, axes)) * axis_reciprocal;
  const Int8 order = Int8::from_bytes(tables::kOrder[sign_bits(axis_reciprocal)]);
  const Float8 t1 = broadcast_lane<kRootLane>(t), t2 = permute(t, shift_right<6>(order)),
               t3 = permute(t, shift_right<3>(order));
  // In this order lanes 0 to 3 are on the far side of the root's plane, and so on.
  const Float8 tn(enter), tx(leave);
  const Float8 en = max_where<0x55>(max_where<0x33>(max_where<0x0f>(tn, t1), t2), t3);
  const Float8 ex = min_where<0xaa>(min_where<0xcc>(min_where<0xf0>(tx, t1), t2), t3);
  const Int8 children = permute(Int8::load(node.child.data()), order);
  const uint32_t near_bit = low_bits_equal(order, near);
  const uint32_t reached = at_most(en, ex * Float8(kWiden)), entered = reached & nonzero_bits(children);
  const auto push = [&](uint32_t mask) {
    const Compress8 compress(mask);
    compress(children).store(&stack.child[top]);
    compress(en).store(&stack.enter[top]);
    compress(ex).store(&stack.leave[top]);
    return static_cast<uint32_t>(std::popcount(mask));
  };
  // Rounding may have taken the point across a plane. Then a child before the near one is reached too, and must come first, or a hit
  // behind it would end the search; or the near one is not reached at all. Intervals decide, as they do in a stream.
  if ((reached & (0U - near_bit)) != near_bit) [[unlikely]] {
    return {kEmptyChild, leave, push(entered)};
  }
  const uint32_t pushed = push(entered & ~near_bit);

  alignas(32) float leaves[8];
  ex.store(leaves);
  return {node.child[near], leaves[std::countr_zero(near_bit)], pushed};
}

// `ray` is in the space of the tree and passed can_hit(). Nearest hit: the hit in (t_min, t_far], which narrows t_far. Any hit:
// true at the first found.
template <bool kAny>
inline bool trace_tree(const Tree& tree, const Ray& ray, float t_min, const CandidateFilter& filter, float& t_far,
                       TreeHit& best) {
  float enter = t_min, leave = t_far;
  if (tree.root == kEmptyChild || !clip_to_box(tree.clip_bounds, ray.origin, ray.direction, enter, leave)) return false;
  const auto* quads =
      reinterpret_cast<const float*>(&ray); // (origin, t_min), (direction, t_max); lane 3 is never selected
  const Float8 origin = Float8::load_twice(quads);
  const Float8 direction = Float8::load_twice(quads + 4);
  const Float8 reciprocal = Float8(1.0f) / direction;
  const RayShear shear = shear_of(ray);
  const bool in_plane = may_lie_in_plane(ray.direction);

  TraversalStack stack;
  size_t top = 1;
  stack.enter[0] = std::numeric_limits<float>::quiet_NaN(); // ends the loop below
  ChildWord child = tree.root;
  Float8 point = origin + Float8(enter) * direction;
  while (true) {
    while (static_cast<int32_t>(child) > 0) {
      const WideStep step = step_down(tree.nodes[child], origin, reciprocal, point, enter, leave, stack, top);
      child = step.child;
      leave = step.leave;
      top += step.pushed;
    }
    if (child != kEmptyChild) {
      const LeafUnit* unit = tree.leaves.data() + (child & ~kLeafBit);
      if (intersect_leaf<kAny>(unit, shear, t_min, filter, t_far, best)) return true;
    }
    --top;
    if (in_plane) [[unlikely]]
      while (stack.enter[top] > t_far) --top;
    enter = stack.enter[top];
    if (!(enter <= t_far)) return !kAny && best.is_hit();
    child = stack.child[top];
    leave = stack.leave[top] < t_far ? stack.leave[top] : t_far;
    point = origin + Float8(enter) * direction;
  }
}

} // namespace kindling::accel::kd::KINDLING_SIMD
