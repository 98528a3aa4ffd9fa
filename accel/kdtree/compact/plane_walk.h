// One ray through a deforming tree with a stack of 512 bytes: scalar, without recursion.
//
// The walk enters the cells that kernels/plane_walk.h enters, in the same order and by the same
// comparisons; the rules there apply. Only the stack differs. A frame of the kernels keeps all
// eight children with their intervals, which costs 4 KB; here it keeps the node with its own
// interval, and a bit for each child that is still to be visited. On return the child's interval is
// computed again from the three planes above it, all in the node that has its reference.
// Considered instead:
//  - children instead of nodes: up to seven of 12 bytes each per level, 2.6 KB;
//  - frames without the interval, which follows from that of the root and the planes on the path:
//    160 bytes, but then every return walks the path again, and registers cannot hold it;
//  - no stack but bits of the path (a restart trail): descends again from the root at each return.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/leaf_test.h"
#include "accel/kdtree/compact/tree_stack.h"
#include "accel/kdtree/view.h"
#include "accel/kdtree/widening.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>

namespace kindling::accel::kd::compact {

// A child of a node, and the part of the ray in it.
struct Cell {
  ChildWord child;
  Interval interval;
};

// A ray in the space of a deforming tree, prepared to walk it.
template <>
class TreeWalk<Deforming> {
 public:
  // The tree is not empty, `ray` satisfies can_hit(), and `t_min` is at least 0.
  [[gnu::always_inline]] TreeWalk(const TreeView& tree, const Deforming& motion, const Ray& ray, float t_min)
      : tree_(tree), nodes_(tree.moving_nodes.data()), motion_(motion), origin_(ray.origin),
        reciprocal_(1.0f / ray.direction.x, 1.0f / ray.direction.y, 1.0f / ray.direction.z), shear_(shear_of(ray)),
        t_min_(t_min) {
    for (int axis = 0; axis < 3; ++axis) down_ |= (std::signbit(component(ray.direction, axis)) ? 1U : 0U) << axis;
    const float x = std::fabs(ray.direction.x), y = std::fabs(ray.direction.y), z = std::fabs(ray.direction.z);
    const float smallest = std::min(std::min(x, y), z);
    steep_ = smallest < std::numeric_limits<float>::min() || smallest < std::max(std::max(x, y), z) * 0x1p-10f;
    margin_ = kExtentTolerance * tree.largest_extent;
    if (steep_)
      plane_margin_ = margin_;
    else
      slack_ = 2.0f * margin_ * (1.0f / smallest);
  }

  // Finds the nearest hit in (t_min, t_far] and narrows t_far to it; any hit: returns true at the
  // first. `accepts(candidate)` decides about meshes that are not opaque.
  template <bool kAny, class Accepts>
  [[gnu::always_inline]] bool run(TreeStack& stack, float& t_far, TreeHit& best, const Accepts& accepts) const {
    const auto test = [&](const LeafUnit* unit) __attribute__((always_inline)) {
      return intersect_leaf<kAny>(unit, motion_, shear_, t_min_, t_far, best, accepts);
    };
    if (visit_leaves(stack, t_far, test)) return true;
    return !kAny && best.is_hit();
  }

 private:
  // Calls test(leaf) for the leaves that the ray enters up to t_far, which the call may narrow,
  // until it returns true, which is then the result.
  template <class Test>
  [[gnu::always_inline]] bool visit_leaves(TreeStack& stack, const float& t_far, const Test& test) const {
    Cell cell{tree_.root, {t_min_, t_far}};
    if (!clip(cell.interval)) return false;
    uint32_t top = 0;
    while (true) {
      while (static_cast<int32_t>(cell.child) > 0) {
        const ChildWord node = cell.child;
        const Interval whole = cell.interval;
        const uint32_t rest = descend(cell);
        if (rest == 0) continue;
        assert(top < TreeStack::kFrames);
        stack.frames[top++] = {node, rest, whole.enter, whole.leave};
      }
      if (cell.child != kEmptyChild) {
        if (test(tree_.leaves.data() + (cell.child & ~kLeafBit))) return true;
      }
      const float end = t_far * kBeyond + 2.0f * slack_;
      do {
        if (top == 0) return false;
        TreeStack::Frame& frame = stack.frames[top - 1];
        cell = child_at(frame.node, static_cast<uint32_t>(std::countr_zero(frame.rest)), {frame.enter, frame.leave});
        frame.rest &= frame.rest - 1;
        if (frame.rest == 0) --top;
        // Cells beyond the hit end the search, unless the ray is steep: then nearer ones may
        // follow.
      } while (steep_ && cell.interval.enter > end);
      if (!(cell.interval.enter <= end)) return false;
      cell.interval = cell.interval.until(end);
    }
  }

  // A plane as the ray meets it, with its margin if the ray is steep.
  struct PlaneCrossing {
    float begin, end; // of what is beyond it, and of what is before it
    uint32_t down;    // 1: the ray comes from above
  };

  [[nodiscard]] bool enters(const Interval& interval) const {
    return interval.enter <= interval.leave * kWiden + slack_;
  }

  // Clips to the tree's box; returns false if nothing is left.
  [[nodiscard]] bool clip(Interval& interval) const {
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<size_t>(axis);
      const float low = between(tree_.clip_bounds.low[k], tree_.clip_bounds_at_end.low[k], motion_.fraction),
                  high = between(tree_.clip_bounds.high[k], tree_.clip_bounds_at_end.high[k], motion_.fraction);
      interval = interval.within(low, high, margin_, component(origin_, axis), component(reciprocal_, axis));
    }
    const bool entered = interval.is_entered();
    interval.enter = std::min(interval.enter, interval.leave); // never beyond the end of the ray
    return entered;
  }

  [[nodiscard]] PlaneCrossing crossing(ChildWord node, uint32_t axes, uint32_t lane) const {
    const auto axis = static_cast<int>((axes >> (2 * lane)) & 3U);
    const float plane = nodes_[node].planes[lane] + nodes_[node].displacements[lane] * motion_.fraction;
    const float distance = plane - component(origin_, axis), reciprocal = component(reciprocal_, axis);
    const uint32_t down = (down_ >> axis) & 1U;
    const float margin = down != 0 ? -plane_margin_ : plane_margin_;
    return {(distance - margin) * reciprocal, (distance + margin) * reciprocal, down};
  }
  // Returns the part of an interval before a plane, or beyond it.
  static Interval part(const Interval& interval, const PlaneCrossing& plane, uint32_t beyond) {
    return beyond != 0 ? interval.from(plane.begin) : interval.until(plane.end);
  }
  static uint32_t axes_of(const MovingNode& node) { return std::bit_cast<uint32_t>(node.planes[kAxesLane]); }

  // Steps from a node to the first child that the ray enters, empty if there is none. Returns the
  // positions of the others that it enters. A position has a bit for each of the three levels, set
  // if the child is beyond the plane.
  [[nodiscard, gnu::always_inline]] uint32_t descend(Cell& cell) const {
    const MovingNode& node = nodes_[cell.child];
    const uint32_t axes = axes_of(node);
    Cell nearest{kEmptyChild, cell.interval};
    uint32_t entered = 0;
    const PlaneCrossing root = crossing(cell.child, axes, kRootLane);
    for (uint32_t far1 = 0; far1 < 2; ++far1) {
      const Interval half = part(cell.interval, root, far1);
      if (!enters(half)) continue; // nor does the ray enter a part of it
      const uint32_t first = far1 ^ root.down;
      const PlaneCrossing second_plane = crossing(cell.child, axes, kSecondLane + first);
      for (uint32_t far2 = 0; far2 < 2; ++far2) {
        const Interval quarter = part(half, second_plane, far2);
        if (!enters(quarter)) continue;
        const uint32_t second = 2 * first + (far2 ^ second_plane.down);
        const PlaneCrossing third_plane = crossing(cell.child, axes, kThirdLane + second);
        for (uint32_t far3 = 0; far3 < 2; ++far3) {
          const Interval eighth = part(quarter, third_plane, far3);
          if (!enters(eighth)) continue;
          const ChildWord child = node.child[2 * second + (far3 ^ third_plane.down)];
          if (child == kEmptyChild) continue;
          if (entered == 0) nearest = {child, eighth};
          entered |= 1U << (4 * far1 + 2 * far2 + far3);
        }
      }
    }
    cell = nearest;
    return entered & (entered - 1);
  }

  // Returns the child at a position, with its interval: the same bits as in descend().
  [[nodiscard]] Cell child_at(ChildWord number, uint32_t position, Interval interval) const {
    const MovingNode& node = nodes_[number];
    const uint32_t axes = axes_of(node), far1 = position >> 2, far2 = (position >> 1) & 1U, far3 = position & 1U;
    const PlaneCrossing root = crossing(number, axes, kRootLane);
    const uint32_t first = far1 ^ root.down;
    const PlaneCrossing second_plane = crossing(number, axes, kSecondLane + first);
    const uint32_t second = 2 * first + (far2 ^ second_plane.down);
    const PlaneCrossing third_plane = crossing(number, axes, kThirdLane + second);
    interval = part(part(part(interval, root, far1), second_plane, far2), third_plane, far3);
    return {node.child[2 * second + (far3 ^ third_plane.down)], interval};
  }

  const TreeView& tree_;
  const MovingNode* nodes_;
  Deforming motion_;
  Imath::V3f origin_, reciprocal_;
  RayShear shear_;
  float t_min_;
  uint32_t down_ = 0;   // bit k: the direction's sign along axis k
  bool steep_ = false;  // see is_steep() in kernels/plane_walk.h
  float margin_ = 0.0f; // that of the tree's box
  float plane_margin_ = 0.0f, slack_ = 0.0f;
};

} // namespace kindling::accel::kd::compact
