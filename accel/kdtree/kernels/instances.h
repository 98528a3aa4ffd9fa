// Traversal of the instance hierarchy by one ray.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Calls visit(box index) for the boxes that the ray enters in [t_min, t_far], roughly front to back
// or, if kAny, in any order. visit may narrow t_far, unless kAny, and ends the search by returning
// true, which is then the result. `instances` has what visit reads of each box; it is fetched
// ahead.
template <bool kAny, class Instance, class Visit>
inline bool visit_instances(const InstanceLevel& level, std::span<const Instance> instances, const Ray& ray,
                            float t_min, const float& t_far, const Visit& visit) {
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
  // Offsets of the faces that the ray meets first, in floats from the beginning of a node.
  constexpr size_t kHigh = offsetof(InstanceNode, high) / sizeof(float);
  const size_t first_x = down_x ? kHigh : 0, first_y = 8 + (down_y ? kHigh : 0), first_z = 16 + (down_z ? kHigh : 0),
               last_x = kHigh - first_x, last_y = 16 + kHigh - first_y, last_z = 32 + kHigh - first_z;

  // Distances and children apart: a wide load of an entry would wait for two narrow stores.
  std::array<float, InstanceLevel::kStackSize> enters;
  std::array<uint32_t, InstanceLevel::kStackSize> children;
  enters[0] = t_min * kBefore;
  children[0] = 0;
  size_t top = 1;
  while (top != 0) {
    --top;
    const uint32_t child = children[top];
    if (!kAny && !(enters[top] <= t_far * kWiden)) continue;
    if ((child & InstanceLevel::kBoxBit) != 0) {
      if (visit(child & ~InstanceLevel::kBoxBit)) return true;
      continue;
    }
    const InstanceLevel::Node& node = level.node(child);
    const float* faces = &node.low[0][0];
    // As in clip_to_box(), NaN imposes no restriction.
    Lanes8 enter = max((Lanes8::load(faces + first_x) - near_x) * rx, begin);
    enter = max((Lanes8::load(faces + first_y) - near_y) * ry, enter);
    enter = max((Lanes8::load(faces + first_z) - near_z) * rz, enter);
    Lanes8 leave = min((Lanes8::load(faces + last_x) - far_x) * rx, Lanes8(t_far * kWiden));
    leave = min((Lanes8::load(faces + last_y) - far_y) * ry, leave);
    leave = min((Lanes8::load(faces + last_z) - far_z) * rz, leave);
    uint32_t mask = at_most(enter, leave * Lanes8(kWiden));
    alignas(32) float entries[8];
    if (!kAny) enter.store(entries);
    const size_t base = top;
    for (; mask != 0; mask &= mask - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(mask));
      const uint32_t entered = node.child[lane];
      if (entered == InstanceLevel::kNone) continue;
      const bool is_box = (entered & InstanceLevel::kBoxBit) != 0;
      prefetch(is_box ? static_cast<const void*>(instances.data() + (entered & ~InstanceLevel::kBoxBit))
                      : &level.node(entered));
      assert(top < children.size());
      size_t place = top++;
      for (; !kAny && place > base && enters[place - 1] < entries[lane]; --place) {
        enters[place] = enters[place - 1];
        children[place] = children[place - 1];
      }
      if (!kAny) enters[place] = entries[lane];
      children[place] = entered;
    }
  }
  return false;
}

} // namespace kindling::accel::kd::KINDLING_SIMD
