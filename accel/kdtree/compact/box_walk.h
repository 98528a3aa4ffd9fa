// One ray through a tree with a stack of 256 bytes: scalar, without recursion.
//
// The walk visits the boxes that kernels/box_walk.h visits, in the same order and by the same
// comparisons; the rules in kernels/traversal.h apply. But a child is tested when it is its turn,
// by which time a hit may have ended the search, so a frame of the stack has the node and the
// position of its next child. (The kernels test all eight at once and keep them with the distances
// at which the ray enters them, which takes 2 KB.)
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/leaf_test.h"
#include "accel/kdtree/compact/tree_stack.h"
#include "accel/kdtree/view.h"
#include "accel/kdtree/widening.h"
#include "accel/motion_keys.h"

#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace kindling::accel::kd::compact {

// The nodes of static and of deforming trees, and their faces across an axis at the ray's time.
[[nodiscard]] inline const BoxNode* nodes_of(const TreeView& tree, Static) { return tree.nodes.data(); }
[[nodiscard]] inline const MovingNode* nodes_of(const TreeView& tree, const Deforming&) {
  return tree.moving_nodes.data();
}
[[nodiscard]] inline float face_of(const BoxNode& node, bool high, uint32_t axis, uint32_t lane, Static) {
  return (high ? node.high : node.low)[axis][lane];
}
[[nodiscard]] inline float face_of(const MovingNode& node, bool high, uint32_t axis, uint32_t lane,
                                   const Deforming& motion) {
  return (high ? node.high : node.low)[axis][lane] +
         (high ? node.high_displacement : node.low_displacement)[axis][lane] * motion.fraction;
}
// Bounds of a tree at the ray's time, between those at both ends of its slice.
[[nodiscard]] inline float bound_of(float at_begin, float /*at_end*/, Static) { return at_begin; }
[[nodiscard]] inline float bound_of(float at_begin, float at_end, const Deforming& motion) {
  return between(at_begin, at_end, motion.fraction);
}

// A ray in the space of a tree, prepared to walk it.
template <class Motion>
class TreeWalk {
  static constexpr bool kInOrder = std::is_same_v<Motion, Static>; // a box beyond a hit ends the ray
  using Node = std::conditional_t<kInOrder, BoxNode, MovingNode>;

 public:
  // The tree is not empty, `ray` satisfies can_hit(), and `t_min` is at least 0.
  [[gnu::always_inline]] TreeWalk(const TreeView& tree, const Motion& motion, const Ray& ray, float t_min)
      : tree_(tree), nodes_(nodes_of(tree, motion)), motion_(motion), origin_(ray.origin), shear_(shear_of(ray)),
        t_min_(t_min) {
    const bool lengthens = may_bend(ray.direction) && is_short(ray.direction);
    const float length = lengthens ? kLengthen : 1.0f;
    unit_ = lengthens ? kShorten : 1.0f;
    reciprocal_ = {finite_reciprocal(ray.direction.x * length), finite_reciprocal(ray.direction.y * length),
                   finite_reciprocal(ray.direction.z * length)};
    for (int axis = 0; axis < 3; ++axis) down_ |= (std::signbit(component(ray.direction, axis)) ? 1U : 0U) << axis;
  }

  // Finds the nearest hit in (t_min, t_far] and narrows t_far to it; any hit: returns true at the
  // first. `accepts(candidate)` decides about meshes that are not opaque.
  template <bool kAny, class Accepts>
  [[gnu::always_inline]] bool run(TreeStack& stack, float& t_far, TreeHit& best, const Accepts& accepts) const {
    const auto test = [&](ChildWord leaf) __attribute__((always_inline)) {
      return intersect_leaf<kAny>(tree_.leaves.data() + (leaf & ~kLeafBit), motion_, shear_, t_min_, t_far, best,
                                  accepts);
    };
    if (!enters_tree(t_far)) return false;
    if ((tree_.root & kLeafBit) != 0) return test(tree_.root) || (!kAny && best.is_hit());
    uint32_t number = tree_.root, position = 0, top = 0;
    while (true) {
      const Node& node = nodes_[number];
      const ChildWord child = next_child(node, position, t_far);
      if (child == kBeyondEnd) break;
      if (child == kEmptyChild) {
        if (top == 0) break;
        number = stack.frames[--top].node;
        position = stack.frames[top].rest;
      } else if ((child & kLeafBit) != 0) {
        if (test(child)) return true;
      } else {
        if (position < kWideLanes) {
          assert(top < TreeStack::kFrames);
          stack.frames[top].node = number;
          stack.frames[top++].rest = position;
        }
        number = child;
        position = 0;
      }
    }
    return !kAny && best.is_hit();
  }

 private:
  static constexpr ChildWord kBeyondEnd = ~0U; // no leaf is there: see kLeafPadding

  // Returns the first child from a position of the ray's order on that the ray enters, and sets the
  // position after it. Returns kEmptyChild if there is none, and kBeyondEnd if what follows lies
  // beyond the end of the ray, in this node and in all others.
  [[nodiscard, gnu::always_inline]] ChildWord next_child(const Node& node, uint32_t& position, float t_far) const {
    const float end = t_far * unit_;
    while (position < kWideLanes) {
      const uint32_t lane = (node.order[down_] >> (4 * position++)) & 7U;
      if (node.child[lane] == kEmptyChild) break; // as are the rest
      Interval inside{t_min_ * unit_, std::numeric_limits<float>::max()};
      for (uint32_t k = 0; k < 3; ++k)
        inside = inside.from(distance(face(node, k, 0, lane), k)).until(distance(face(node, k, 1, lane), k));
      if (!inside.is_entered()) continue;
      if (kInOrder && !(inside.enter <= end * kBeyond)) return kBeyondEnd;
      if (inside.until(end).is_entered()) return node.child[lane];
    }
    position = kWideLanes;
    return kEmptyChild;
  }
  // Returns the face of a child's box across an axis that the ray meets first, or last.
  [[nodiscard]] float face(const Node& node, uint32_t k, uint32_t last, uint32_t lane) const {
    return face_of(node, ((down_ >> k) & 1U) != last, k, lane, motion_);
  }
  [[nodiscard]] float distance(float face, uint32_t k) const {
    const auto axis = static_cast<int>(k);
    return (face - component(origin_, axis)) * component(reciprocal_, axis);
  }

  [[nodiscard]] bool enters_tree(float t_far) const {
    Interval interval{t_min_ * unit_, t_far * unit_};
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<size_t>(axis);
      const PlainBox &begin = tree_.clip_bounds, &end = tree_.clip_bounds_at_end;
      interval =
          interval.within(bound_of(begin.low[k], end.low[k], motion_), bound_of(begin.high[k], end.high[k], motion_),
                          0.0f, component(origin_, axis), component(reciprocal_, axis));
    }
    return interval.is_entered();
  }

  const TreeView& tree_;
  const Node* nodes_;
  [[no_unique_address]] Motion motion_;
  Imath::V3f origin_, reciprocal_;
  RayShear shear_;
  float t_min_, unit_; // distances to boxes are multiplied by `unit_`: not 1 if the direction is_short()
  uint32_t down_ = 0;  // bit k: the direction's sign along axis k
};

} // namespace kindling::accel::kd::compact
