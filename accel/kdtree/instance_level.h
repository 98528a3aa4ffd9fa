// The upper level: a bounding volume hierarchy of eight children per node over the boxes of moved instances.
//
// Instances overlap and are few, so object splits serve better here than planes that would put one instance into many leaves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/kdtree/aligned_array.h"
#include "accel/kdtree/simd8.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

namespace kindling::accel::kd {

class InstanceLevel {
 public:
  InstanceLevel() = default;
  // Boxes in world space, none empty; conservative. Deterministic.
  explicit InstanceLevel(std::span<const Imath::Box3f> boxes);

  [[nodiscard]] bool empty() const { return nodes_.size() == 0; }
  [[nodiscard]] size_t node_count() const { return nodes_.size(); }
  [[nodiscard]] size_t memory_bytes() const { return nodes_.size() * sizeof(Node); }

  // Calls visit(number of the box) for the boxes that the ray enters in [t_min, t_far], roughly front to back. visit may
  // narrow t_far, and ends the search by returning true, which is then the result.
  template <class Visit>
  bool visit(const Ray& ray, float t_min, const float& t_far, const Visit& visit) const;

 private:
  static constexpr uint32_t kBoxBit = 0x80000000U;
  static constexpr uint32_t kNone = 0x7fffffffU;
  static constexpr uint32_t kSahDepth = 40; // below, halves: bounds the depth, and so the stack
  static constexpr size_t kStackSize = 7 * (kSahDepth + 32) + 9;

  struct alignas(64) Node {
    float low[3][8], high[3][8];
    std::array<uint32_t, 8> child; // node, or kBoxBit and the number of a box, or kNone
  };
  static_assert(sizeof(Node) == 256);

  struct Builder;
  AlignedArray<Node> nodes_; // 0 is the root
};

template <class Visit>
bool InstanceLevel::visit(const Ray& ray, float t_min, const float& t_far, const Visit& visit) const {
  struct Entry {
    float enter;
    uint32_t child;
  };
  if (empty()) return false;
  const Imath::V3f& o = ray.origin;
  const Imath::V3f& d = ray.direction;
  const Float8 ox(o.x), oy(o.y), oz(o.z), rx(1.0f / d.x), ry(1.0f / d.y), rz(1.0f / d.z);
  const bool down_x = std::signbit(d.x), down_y = std::signbit(d.y), down_z = std::signbit(d.z);

  std::array<Entry, kStackSize> stack;
  size_t top = 0;
  stack[top++] = {t_min, 0};
  while (top != 0) {
    const Entry entry = stack[--top];
    if (!(entry.enter <= t_far * (1.0f + 5e-7f))) continue;
    if ((entry.child & kBoxBit) != 0) {
      if (visit(entry.child & ~kBoxBit)) return true;
      continue;
    }
    const Node& node = nodes_[entry.child];
    const auto low = [&](int axis, bool down) { return Float8::load(down ? node.high[axis] : node.low[axis]); };
    // As in clip_to_box(): NaN means no restriction.
    Float8 enter = max((low(0, down_x) - ox) * rx, Float8(t_min));
    enter = max((low(1, down_y) - oy) * ry, enter);
    enter = max((low(2, down_z) - oz) * rz, enter);
    Float8 leave = min((low(0, !down_x) - ox) * rx, Float8(t_far));
    leave = min((low(1, !down_y) - oy) * ry, leave);
    leave = min((low(2, !down_z) - oz) * rz, leave);
    uint32_t mask = (enter <= leave * Float8(1.0f + 5e-7f)).bits();
    alignas(32) float enters[8];
    enter.store(enters);
    const size_t base = top;
    for (; mask != 0; mask &= mask - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(mask));
      if (node.child[lane] == kNone) continue;
      size_t place = top++;
      for (; place > base && stack[place - 1].enter < enters[lane]; --place) stack[place] = stack[place - 1];
      stack[place] = {enters[lane], node.child[lane]};
    }
  }
  return false;
}

} // namespace kindling::accel::kd
