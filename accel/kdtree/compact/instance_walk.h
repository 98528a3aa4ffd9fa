// One ray through the hierarchy over the boxes of instances, with a stack of 360 bytes.
//
// A frame has a node and a bit for each child that is still to be visited, without distances. On
// return the boxes of these children are tested again: that finds the nearest of them, and drops
// those beyond a hit found meanwhile. Keeping the children with their distances, as
// kernels/instances.h does, takes 4 KB.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/view.h"
#include "accel/kdtree/widening.h"
#include "accel/ray.h"

#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>

namespace kindling::accel::kd::compact {

struct InstanceStack {
  static constexpr uint32_t kFrames = InstanceNode::kMaxDepth; // one for each node of a path
  std::array<uint32_t, kFrames> node;
  std::array<uint8_t, kFrames> rest;
};
static_assert(sizeof(InstanceStack) == 360);

// A world ray prepared for boxes. Instances' transforms round the ray, so boxes are entered earlier
// and left later by a margin.
class BoxRay {
 public:
  BoxRay(const Ray& ray, float margin)
      : reciprocal_{1.0f / ray.direction.x, 1.0f / ray.direction.y, 1.0f / ray.direction.z} {
    const float origin[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
    const float direction[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
    for (int k = 0; k < 3; ++k) {
      down_[k] = std::signbit(direction[k]);
      const float outwards = down_[k] ? -margin : margin;
      near_[k] = origin[k] + outwards;
      far_[k] = origin[k] - outwards;
    }
  }

  // Narrows [enter, leave] to the part inside a box of a node; returns false if nothing is left.
  // NaN imposes no restriction.
  [[nodiscard]] bool clip(const InstanceNode& node, uint32_t lane, float& enter, float leave) const {
    for (int k = 0; k < 3; ++k) {
      const float low = node.low[k][lane], high = node.high[k][lane];
      const float begin = ((down_[k] ? high : low) - near_[k]) * reciprocal_[k];
      const float end = ((down_[k] ? low : high) - far_[k]) * reciprocal_[k];
      enter = begin > enter ? begin : enter;
      leave = end < leave ? end : leave;
    }
    return enter <= leave * kWiden;
  }

 private:
  float reciprocal_[3], near_[3], far_[3];
  bool down_[3];
};

// Calls visit(box index) for the boxes that the ray enters in [t_min, t_far], roughly front to back
// or, if kAny, in any order. visit may narrow t_far, unless kAny, and ends
// the search by returning true, which is then the result.
template <bool kAny, class Visit>
[[gnu::always_inline]] inline bool visit_instances(const InstanceLevelView& level, const Ray& ray, float t_min,
                                                   const float& t_far, InstanceStack& stack, const Visit& visit) {
  if (level.nodes.empty()) return false;
  const BoxRay box_ray(ray, level.margin(ray.origin));
  uint32_t top = 0, number = 0, rest = 0xff;
  while (true) {
    const InstanceNode& node = level.nodes[number];
    uint32_t entered = 0, nearest = 0;
    float nearest_enter = 0.0f;
    for (uint32_t bits = rest; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<uint32_t>(std::countr_zero(bits));
      if (node.child[lane] == InstanceNode::kNone) continue;
      float enter = t_min * kBefore;
      if (!box_ray.clip(node, lane, enter, t_far * kWiden)) continue;
      if (kAny || entered == 0 || enter <= nearest_enter) {
        nearest = lane;
        nearest_enter = enter;
      }
      entered |= 1U << lane;
    }
    if (entered == 0) {
      if (top == 0) return false;
      number = stack.node[--top];
      rest = stack.rest[top];
      continue;
    }
    rest = entered & ~(1U << nearest);
    const uint32_t child = node.child[nearest];
    if ((child & InstanceNode::kBoxBit) != 0) {
      if (visit(child & ~InstanceNode::kBoxBit)) return true;
      continue;
    }
    if (rest != 0) {
      assert(top < InstanceStack::kFrames);
      stack.node[top] = number;
      stack.rest[top++] = static_cast<uint8_t>(rest);
    }
    number = child;
    rest = 0xff;
  }
}

} // namespace kindling::accel::kd::compact
