// One ray through a tree with a stack of 256 bytes: scalar, without recursion.
//
// The walk visits the boxes that kernels/box_walk.h visits, in the same order and by the same
// comparisons; the rules in kernels/traversal.h apply. All eight boxes of a node are tested at
// once, and a frame of the stack has the node and a bit for each child that is still to be visited.
// When it is a child's turn, a hit may have ended the search, so the distance at which the ray
// enters its box is compared once more. (The kernels keep these distances, which takes 2 KB.)
//
// The rays of neighboring threads of a GPU differ, and a warp executes each way that some thread
// takes. So there is one loop, in which every thread takes a step: into the next child, or to the
// next triangles of a leaf; and it ends at one place (see meet()).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/leaf_test.h"
#include "accel/kdtree/compact/rows.h"
#include "accel/kdtree/compact/tree_stack.h"
#include "accel/kdtree/view.h"
#include "accel/kdtree/widening.h"
#include "accel/motion_keys.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
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
// Vectors wider than the target's registers are passed in memory; all functions are inlined, so no
// binary interface depends on it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

// The same of all children.
static_assert(offsetof(BoxNode, low) % sizeof(Float8) == 0 && offsetof(BoxNode, child) % sizeof(Float8) == 0 &&
              offsetof(MovingNode, child) % sizeof(Float8) == 0 &&
              offsetof(MovingNode, low_displacement) % sizeof(Float8) == 0);
[[nodiscard, gnu::always_inline]] inline Float8 row_of(const std::array<std::array<float, kWideLanes>, 3>& rows,
                                                       uint32_t axis) {
  return row_at(rows[axis].data());
}
[[nodiscard, gnu::always_inline]] inline Float8 faces_of(const BoxNode& node, bool high, uint32_t axis, Static) {
  return row_of(high ? node.high : node.low, axis);
}
[[nodiscard, gnu::always_inline]] inline Float8 faces_of(const MovingNode& node, bool high, uint32_t axis,
                                                         const Deforming& motion) {
  return row_of(high ? node.high : node.low, axis) +
         row_of(high ? node.high_displacement : node.low_displacement, axis) * motion.fraction;
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

  // Finds the nearest hit in (t_min, end_of_ray], and moves the end to it; any hit: returns true at
  // the first. `accepts(candidate)` decides about meshes that are not opaque.
  template <bool kAny, class Accepts>
  [[gnu::always_inline]] bool run(TreeStack& stack, float& end_of_ray, TreeHit& best, const Accepts& accepts) const {
    float t_far = end_of_ray; // in a register
    Place place{.child = tree_.root};
    NearestCrossing nearest;
    uint32_t ended = enters_tree(t_far) ? 0 : 1;
    while (ended == 0) {
      if (place.unit == nullptr) ended = next_node(stack, t_far, place);
      for (uint32_t i = 0; i < kTrianglesPerStep; ++i) {
        if (meet(place.unit) == nullptr) continue;
        if (test_triangle(place.unit, place.triangle, motion_, shear_, t_min_, t_far, nearest, accepts)) {
          t_far = nearest.at.t;
          if (kAny) ended = 1;
        }
        next_triangle(place);
      }
      ended = meet(ended);
    }
    if (!nearest.is_hit()) return false;
    if (kAny) return true;
    end_of_ray = t_far;
    best = nearest.template hit<Block>();
    return true;
  }

 private:
  using Block = typename LeafOf<Motion>::Block;
  static constexpr uint32_t kTrianglesPerStep = 2;

  // The place of a ray in the tree.
  struct Place {
    ChildWord child = kEmptyChild;  // the root until the ray enters it; then empty
    uint32_t node = 0, rest = 0;    // the node, and its children that are still to be visited, by the ray's order
    uint32_t top = 0;               // number of frames on the stack
    const LeafUnit* unit = nullptr; // the block of a leaf, if the ray is in one
    uint32_t triangle = 0;          // of the block: the next
  };

  // Enters the next child: moves to its first triangle, or finds which of its own children the ray
  // enters. Returns 1 if there is none, or none before the end of the ray, else 0.
  [[nodiscard, gnu::always_inline]] uint32_t next_node(TreeStack& stack, float t_far, Place& place) const {
    const float end = t_far * unit_;
    ChildWord child = place.child;
    place.child = kEmptyChild;
    if (child == kEmptyChild) {
      if (place.rest == 0) {
        if (place.top == 0) return 1;
        const TreeStack::Frame& frame = stack.frames[--place.top];
        place.node = frame.node;
        place.rest = frame.rest;
      }
      const Node& node = nodes_[place.node];
      const auto position = static_cast<uint32_t>(std::countr_zero(place.rest));
      place.rest &= place.rest - 1;
      const uint32_t lane = lane_at(node.order[down_], position);
      if (!(distance_to(node, lane) <= end * kBeyond)) return kInOrder ? 1 : 0;
      child = node.child[lane];
    }
    if ((child & kLeafBit) != 0) {
      place.unit = tree_.leaves.data() + (child & ~kLeafBit);
      return 0;
    }
    if (place.rest != 0) {
      assert(place.top < TreeStack::kFrames);
      stack.frames[place.top].node = place.node;
      stack.frames[place.top++].rest = place.rest;
    }
    place.node = child;
    place.rest = entered_children(nodes_[child], end);
    return 0;
  }

  // Moves to the triangle after this one.
  [[gnu::always_inline]] static void next_triangle(Place& place) {
    const Block block(place.unit);
    if (++place.triangle < block.triangle_count()) return;
    const uint32_t next = block.units_to_next();
    place.unit = next == 0 ? nullptr : place.unit + next;
    place.triangle = 0;
  }

  // Returns the lane of a child by its position in the ray's order.
  [[nodiscard]] static uint32_t lane_at(uint32_t order, uint32_t position) { return (order >> (4 * position)) & 7U; }

  // Returns a bit for each position in the ray's order whose child the ray enters before `end`.
  [[nodiscard, gnu::always_inline]] uint32_t entered_children(const Node& node, float end) const {
    Float8 enter = splat(t_min_ * unit_), leave = splat(end);
    for (uint32_t k = 0; k < 3; ++k) {
      const bool is_down = ((down_ >> k) & 1U) != 0;
      enter = larger(enter, distance(faces_of(node, is_down, k, motion_), k));
      leave = smaller(leave, distance(faces_of(node, !is_down, k, motion_), k));
    }
    const uint32_t lanes =
        sign_bits((enter <= leave * kWiden) & (*reinterpret_cast<const AlignedChildren*>(node.child.data()) != 0));
    uint32_t positions = 0;
    const uint32_t order = node.order[down_];
    for (uint32_t i = 0; i < kWideLanes; ++i) positions |= ((lanes >> lane_at(order, i)) & 1U) << i;
    return positions;
  }
  // Returns the distance at which the ray enters a child.
  [[nodiscard]] float distance_to(const Node& node, uint32_t lane) const {
    float enter = t_min_ * unit_;
    for (uint32_t k = 0; k < 3; ++k) {
      const bool is_down = ((down_ >> k) & 1U) != 0;
      enter = std::max(enter, distance(face_of(node, is_down, k, lane, motion_), k));
    }
    return enter;
  }
  // `face`: one, or those of all children.
  template <class Real>
  [[nodiscard, gnu::always_inline]] Real distance(const Real& face, uint32_t k) const {
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

#pragma GCC diagnostic pop

} // namespace kindling::accel::kd::compact
