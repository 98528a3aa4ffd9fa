// The stack of a walk through a tree, and intervals of a ray.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/child_word.h"
#include "accel/kdtree/widening.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace kindling::accel::kd::compact {

// Nodes on the path with children still to visit, 8 bytes each.
struct TreeStack {
  struct alignas(8) Frame {
    uint32_t node;
    uint32_t rest; // bit i: child i, in the order of the ray, is still to be visited
  };
  static constexpr uint32_t kFrames = kMaxWideDepth; // one for each node of a path
  std::array<Frame, kFrames> frames;
};
static_assert(sizeof(TreeStack) == 256);

struct Interval {
  float enter, leave;

  // Cuts the interval at a plane; NaN, from 0 * infinity, imposes no restriction.
  [[nodiscard]] Interval from(float begin) const { return {begin > enter ? begin : enter, leave}; }
  [[nodiscard]] Interval until(float end) const { return {enter, end < leave ? end : leave}; }
  // Cuts it at two faces of a box, moved outwards by `margin`, that are perpendicular to an axis.
  [[nodiscard]] Interval within(float low, float high, float margin, float origin, float reciprocal) const {
    const float at_low = ((low - origin) - margin) * reciprocal, at_high = ((high - origin) + margin) * reciprocal;
    const bool down = std::signbit(reciprocal);
    return from(down ? at_high : at_low).until(down ? at_low : at_high);
  }
  [[nodiscard]] bool is_entered() const { return enter <= leave * kWiden; }
};

} // namespace kindling::accel::kd::compact
