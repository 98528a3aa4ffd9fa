// One ray through the hierarchy over the boxes of instances, with a stack of 360 bytes.
//
// A frame has a node and a bit for each child that is still to be visited, without distances. On
// return the boxes of these children are tested again: that finds the nearest of them, and drops
// those beyond a hit found meanwhile. Keeping the children with their distances, as
// kernels/instances.h does, takes 4 KB.
//
// The neighboring threads of a GPU find the boxes that their rays enter after different numbers of
// nodes. Each continues until it has one; then all trace what their boxes hold together.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/compact/rows.h"
#include "accel/kdtree/view.h"
#include "accel/kdtree/widening.h"
#include "accel/ray.h"

#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace kindling::accel::kd::compact {

struct InstanceStack {
  static constexpr uint32_t kFrames = InstanceNode::kMaxDepth; // one for each node of a path
  std::array<uint32_t, kFrames> node;
  std::array<uint8_t, kFrames> rest;
};
static_assert(sizeof(InstanceStack) == 360);

// Vectors wider than the target's registers are passed in memory; all functions are inlined, so no
// binary interface depends on it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

static_assert(offsetof(InstanceNode, low) % sizeof(Float8) == 0 && offsetof(InstanceNode, child) % sizeof(Float8) == 0);

// A world ray on its way through the hierarchy. Instances' transforms round the ray, so boxes are
// entered earlier and left later by a margin.
template <bool kAny>
class InstanceWalk {
 public:
  static constexpr uint32_t kEnd = ~0U;

  // The hierarchy is not empty.
  InstanceWalk(const InstanceLevelView& level, const Ray& ray, float t_min, InstanceStack& stack)
      : nodes_(level.nodes.data()), stack_(stack), t_min_(t_min) {
    const float margin = level.margin(ray.origin);
    for (int k = 0; k < 3; ++k) {
      const float origin = component(ray.origin, k), direction = component(ray.direction, k);
      const bool down = std::signbit(direction);
      const float outwards = down ? -margin : margin;
      down_ |= (down ? 1U : 0U) << k;
      near_[k] = origin + outwards;
      far_[k] = origin - outwards;
      reciprocal_[k] = 1.0f / direction;
    }
  }

  // Returns the index of the next box that the ray enters in [t_min, t_far], or kEnd; roughly front
  // to back or, if kAny, in any order. t_far may fall from call to call.
  [[nodiscard, gnu::always_inline]] uint32_t next(float t_far) {
    uint32_t found = kNone;
    while (meet(found) == kNone) {
      const InstanceNode& node = nodes_[number_];
      uint32_t nearest = 0;
      const uint32_t entered = entered_children(node, t_far, nearest);
      if (entered == 0) {
        if (top_ == 0) {
          found = kEnd;
        } else {
          number_ = stack_.node[--top_];
          rest_ = stack_.rest[top_];
        }
      } else {
        rest_ = entered & ~(1U << nearest);
        const uint32_t child = node.child[nearest];
        if ((child & InstanceNode::kBoxBit) != 0) {
          found = child & ~InstanceNode::kBoxBit;
        } else {
          if (rest_ != 0) {
            assert(top_ < InstanceStack::kFrames);
            stack_.node[top_] = number_;
            stack_.rest[top_++] = static_cast<uint8_t>(rest_);
          }
          number_ = child;
          rest_ = kAll;
        }
      }
    }
    return found;
  }

 private:
  static constexpr uint32_t kNone = kEnd - 1; // no box found yet
  static constexpr uint32_t kAll = 0xff;      // all children

  // Returns a bit for each child among rest_ whose box the ray enters, and finds the nearest.
  [[nodiscard, gnu::always_inline]] uint32_t entered_children(const InstanceNode& node, float t_far,
                                                              uint32_t& nearest) const {
    Float8 enter = splat(t_min_ * kBefore), leave = splat(t_far * kWiden);
    for (uint32_t k = 0; k < 3; ++k) { // NaN imposes no restriction
      const bool is_down = ((down_ >> k) & 1U) != 0;
      enter = larger((row_at((is_down ? node.high : node.low)[k]) - near_[k]) * reciprocal_[k], enter);
      leave = smaller((row_at((is_down ? node.low : node.high)[k]) - far_[k]) * reciprocal_[k], leave);
    }
    const auto& children = *reinterpret_cast<const AlignedChildren*>(node.child.data());
    const uint32_t entered =
        sign_bits((enter <= leave * kWiden) & (children != static_cast<int32_t>(InstanceNode::kNone))) & rest_;
    if constexpr (kAny) {
      nearest = 31U - static_cast<uint32_t>(std::countl_zero(entered | 1U));
    } else {
      float nearest_enter = std::numeric_limits<float>::infinity();
      for (uint32_t lane = 0; lane < 8; ++lane) {
        const bool is_nearer = ((entered >> lane) & 1U) != 0 && enter[lane] <= nearest_enter;
        nearest = is_nearer ? lane : nearest;
        nearest_enter = is_nearer ? enter[lane] : nearest_enter;
      }
    }
    return entered;
  }

  const InstanceNode* nodes_;
  InstanceStack& stack_;
  float t_min_;
  std::array<float, 3> near_, far_, reciprocal_;
  uint32_t down_ = 0;                           // bit k: the direction's sign along axis k
  uint32_t top_ = 0, number_ = 0, rest_ = kAll; // frames on the stack; the node; its children still to be visited
};

#pragma GCC diagnostic pop

// Calls visit(box index) for the boxes that the ray enters in [t_min, t_far]. visit may narrow
// t_far, unless kAny, and ends the search by returning true, which is then the result.
template <bool kAny, class Visit>
[[gnu::always_inline]] inline bool visit_instances(const InstanceLevelView& level, const Ray& ray, float t_min,
                                                   const float& t_far, InstanceStack& stack, const Visit& visit) {
  if (level.nodes.empty()) return false;
  InstanceWalk<kAny> walk(level, ray, t_min, stack);
  while (true) {
    const uint32_t box = walk.next(t_far);
    if (box == InstanceWalk<kAny>::kEnd) return false;
    if (meet<uint32_t>(visit(box) ? 1 : 0) != 0) return true;
  }
}

} // namespace kindling::accel::kd::compact
