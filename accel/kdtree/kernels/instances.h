// Traversal of the instance hierarchy by one ray.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Calls visit(box index) for the boxes that the ray enters in [t_min, t_far], roughly front to back
// or, if kAny, in any order. visit may narrow t_far, unless kAny, and ends the search by returning
// true, which is then the result. `instances` has what visit reads of each box; it is fetched
// ahead. Begins at a node of the hierarchy.
template <bool kAny, class Instance, class Visit>
inline bool visit_instances(const InstanceLevel& level, std::span<const Instance> instances, const Ray& ray,
                            float t_min, const float& t_far, const Visit& visit, uint32_t root = 0) {
  if (level.empty()) return false;
  const Imath::V3f& o = ray.origin;
  // Distances to boxes count in units of `length` where reciprocals would be infinite otherwise.
  const bool lengthens = may_bend(ray.direction) && is_short(ray.direction);
  const float length = lengthens ? kLengthen : 1.0f, unit = lengthens ? kShorten : 1.0f;
  // The object-space ray differs from the exact one, so boxes are entered earlier and left later.
  const float margin = level.margin(o);
  constexpr size_t kHigh = offsetof(InstanceNode, high) / sizeof(float);
  std::array<Lanes8, 3> near, far, reciprocal; // where the ray would begin; for the faces that it meets first and last
  std::array<size_t, 3> first, last;           // positions of these faces, in floats from the beginning of a node
  uint32_t signs = 0;
  for (size_t k = 0; k < 3; ++k) {
    const float origin = o[static_cast<int>(k)], d = ray.direction[static_cast<int>(k)] * length;
    const bool down = std::signbit(d);
    reciprocal[k] = Lanes8(kd::finite_reciprocal(d));
    near[k] = Lanes8(origin + (down ? -margin : margin));
    far[k] = Lanes8(origin - (down ? -margin : margin));
    first[k] = 8 * k + (down ? kHigh : 0);
    last[k] = 8 * k + (down ? 0 : kHigh);
    signs |= static_cast<uint32_t>(down) << k;
  }
  const Lanes8 begin(t_min * kBefore * unit);

  // The children of a node, where the ray enters their boxes, and, unless kAny, in its order.
  struct alignas(64) Frame {
    std::array<float, 8> enter;
    std::array<uint32_t, 8> child;
  };
  std::array<Frame, InstanceNode::kMaxDepth + 1> frames;
  std::array<uint8_t, InstanceNode::kMaxDepth + 1> rests; // by frame; bit i: child i is still to be visited
  size_t top = 0;
  uint32_t rest = 0, child = root;
  while (true) {
    const InstanceLevel::Node& node = level.node(child);
    rests[top] = static_cast<uint8_t>(rest);
    top += static_cast<size_t>(rest != 0);
    assert(top < frames.size());
    Frame& frame = frames[top];
    const float* faces = &node.low[0][0];
    const Lanes8 end(t_far * kWiden * unit);
    const auto distance = [&](size_t face, const Lanes8& from, size_t k) __attribute__((always_inline)) {
      return (Lanes8::load(faces + face) - from) * reciprocal[k];
    };
    const Lanes8 enter = max(max(begin, distance(first[0], near[0], 0)),
                             max(distance(first[1], near[1], 1), distance(first[2], near[2], 2)));
    const Lanes8 leave =
        min(min(end, distance(last[0], far[0], 0)), min(distance(last[1], far[1], 1), distance(last[2], far[2], 2)));
    if constexpr (kAny) {
      IntLanes8::load(node.child.data()).store(frame.child.data());
      rest = at_most(enter, leave * Lanes8(kWiden));
    } else {
      const IntLanes8 order = shift_by_nibbles(IntLanes8(node.order[signs]));
      const Lanes8 entries = permute(enter, order);
      entries.store(frame.enter.data());
      permute(IntLanes8::load(node.child.data()), order).store(frame.child.data());
      rest = at_most(entries, permute(leave * Lanes8(kWiden), order));
    }
    while (true) {
      while (rest == 0) {
        if (top == 0) return false;
        rest = rests[--top];
      }
      const auto next = static_cast<size_t>(std::countr_zero(rest));
      rest &= rest - 1;
      child = frames[top].child[next];
      if (!kAny && !(frames[top].enter[next] <= t_far * kWiden * unit)) continue;
      const bool is_box = (child & InstanceLevel::kBoxBit) != 0;
      if (!is_box) break;
      prefetch(instances.data() +
               (frames[top].child[static_cast<size_t>(std::countr_zero(rest)) % 8] & ~InstanceLevel::kBoxBit));
      if (visit(child & ~InstanceLevel::kBoxBit)) return true;
    }
  }
}

} // namespace kindling::accel::kd::KINDLING_SIMD
