// Traversal of the instance hierarchy by one ray.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Calls visit(box index) for the boxes that the ray enters in [t_min, t_far], roughly front to
// back. visit may narrow t_far, and ends the search by returning true, which is then the result.
template <class Visit>
inline bool visit_instances(const InstanceLevel& level, const Ray& ray, float t_min, const float& t_far,
                            const Visit& visit) {
  struct Entry {
    float enter;
    uint32_t child;
  };
  if (level.empty()) return false;
  const Imath::V3f& o = ray.origin;
  const Imath::V3f& d = ray.direction;
  const Lanes8 rx(1.0f / d.x), ry(1.0f / d.y), rz(1.0f / d.z);
  const bool down_x = std::signbit(d.x), down_y = std::signbit(d.y), down_z = std::signbit(d.z);
  // The object-space ray differs from the exact one, so boxes are entered earlier and left later.
  const float margin = level.margin(o), mx = down_x ? -margin : margin, my = down_y ? -margin : margin,
              mz = down_z ? -margin : margin;
  const Lanes8 near_x(o.x + mx), near_y(o.y + my), near_z(o.z + mz), far_x(o.x - mx), far_y(o.y - my), far_z(o.z - mz);
  const Lanes8 begin(t_min * kBefore);

  std::array<Entry, InstanceLevel::kStackSize> stack;
  size_t top = 0;
  stack[top++] = {t_min * kBefore, 0};
  while (top != 0) {
    const Entry entry = stack[--top];
    if (!(entry.enter <= t_far * kWiden)) continue;
    if ((entry.child & InstanceLevel::kBoxBit) != 0) {
      if (visit(entry.child & ~InstanceLevel::kBoxBit)) return true;
      continue;
    }
    const InstanceLevel::Node& node = level.node(entry.child);
    const auto low = [&](int axis, bool down) { return Lanes8::load(down ? node.high[axis] : node.low[axis]); };
    // As in clip_to_box(), NaN imposes no restriction.
    Lanes8 enter = max((low(0, down_x) - near_x) * rx, begin);
    enter = max((low(1, down_y) - near_y) * ry, enter);
    enter = max((low(2, down_z) - near_z) * rz, enter);
    Lanes8 leave = min((low(0, !down_x) - far_x) * rx, Lanes8(t_far * kWiden));
    leave = min((low(1, !down_y) - far_y) * ry, leave);
    leave = min((low(2, !down_z) - far_z) * rz, leave);
    uint32_t mask = at_most(enter, leave * Lanes8(kWiden));
    alignas(32) float enters[8];
    enter.store(enters);
    const size_t base = top;
    for (; mask != 0; mask &= mask - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(mask));
      if (node.child[lane] == InstanceLevel::kNone) continue;
      assert(top < stack.size());
      size_t place = top++;
      for (; place > base && stack[place - 1].enter < enters[lane]; --place) stack[place] = stack[place - 1];
      stack[place] = {enters[lane], node.child[lane]};
    }
  }
  return false;
}

} // namespace kindling::accel::kd::KINDLING_SIMD
