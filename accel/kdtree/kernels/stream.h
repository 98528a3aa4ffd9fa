// Many independent rays through one tree at once: while one waits for memory or for its own arithmetic, the others go on.
//
// Each ray has a slot with its state and its own stack. A round takes every ray that stands at a node one wide node down, then
// every ray that stands at a leaf through one of its blocks, then hands out the finished ones and refills their slots. A step down leaves
// a frame on the stack: the children in the order of the ray, their intervals, and a bit for each that it enters. A ray moves on by
// taking the first bit of its topmost frame, and enters the queue for nodes, for leaves or for finished rays by adding comparisons
// to the three counters: there is no branch to predict but that a triangle is hit. What a ray does and finds depends on nothing
// but itself. Its arithmetic is that of trace_tree(), which differs in one thing: it enters the near child in any case.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/ray_lanes.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Rays in flight. More hide more latency until their stacks no longer fit the first-level cache.
inline constexpr uint32_t kStreamSlots = 32;
// Fewer rays than this are faster one by one.
inline constexpr size_t kSmallestStream = 4;
// Lines that are fetched of a leaf block; a full one has five.
inline constexpr size_t kBlockLines = 4;

// About 140 KB, meant for the stack; nothing is initialized before it is used.
template <bool kAny>
class Stream {
 public:
  Stream(const Tree& tree, const HitFilter& filter) : tree_(tree), filter_(filter) {}
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  // Calls finish(number of the ray, nearest hit or, if kAny, any) once for each ray that hits something, in any order.
  template <class Finish>
  void trace(std::span<const Ray> rays, const Finish& finish) {
    if (tree_.root == kEmptyChild) return;
    for (uint32_t s = 0; s < kStreamSlots; ++s) free_[s] = reinterpret_cast<Slot*>(&slots_[s * sizeof(Slot)]);
    uint32_t free_count = kStreamSlots;
    size_t next = 0;
    Counts counts;
    while (true) {
      fill(rays, next, free_count, counts, finish);
      if (counts.node + counts.leaf == 0) break;
      descend(counts);
      test_leaves(rays, counts);
      for (uint32_t k = 0; k < counts.done; ++k) {
        Slot* slot = done_[k];
        if (slot->best.is_hit()) finish(slot->ray, slot->best);
        free_[free_count++] = slot;
      }
      counts.done = 0;
    }
  }

 private:
  // The children of one wide node, near ones first.
  struct alignas(64) Frame {
    std::array<float, kWideLanes> enter, leave;
    std::array<ChildWord, kWideLanes> child;
    uint32_t rest; // bit i: child i is still to be visited
  };
  static_assert(sizeof(Frame) == 128);
  // What a ray is to the tree: one cache line.
  struct alignas(64) PreparedRay {
    std::array<float, 3> origin;
    float t_min;
    std::array<float, 3> reciprocal;
    float t_far; // -1 once any hit will do
    std::array<float, 3> shear;
    uint32_t axes;      // of the sheared space: kx, ky, kz in a byte each from the lowest up
    float enter, leave; // where the ray stands
    std::array<float, 2> spare;
  };
  static_assert(sizeof(PreparedRay) == 64);
  struct alignas(64) Slot {
    PreparedRay at;
    std::array<float, 8> t; // distances of the planes of the node
    TreeHit best;
    ChildWord child; // where the ray stands
    uint32_t ray;
    uint32_t top; // frames on the stack
    uint32_t spare[9];
    std::array<Frame, kMaxWideDepth + 2> stack; // the lowest ends the ray; a step may write one above the top
  };
  // An odd number of cache lines: equal places of different slots do not compete for one set of the cache.
  static_assert(sizeof(Slot) / 64 % 2 == 1);
  static_assert(std::is_trivially_destructible_v<Slot>);
  using Queue = std::array<Slot*, kStreamSlots + 2>; // appending writes before it knows
  struct Counts {
    uint32_t node = 0, leaf = 0, done = 0;
  };

  // Puts rays into free slots, as long as there are both.
  template <class Finish>
  void fill(std::span<const Ray> rays, size_t& next, uint32_t& free_count, Counts& counts, const Finish& finish) {
    const bool root_is_leaf = (tree_.root & kLeafBit) != 0;
    Queue& queue = root_is_leaf ? leaf_ : node_;
    uint32_t& count = root_is_leaf ? counts.leaf : counts.node;
    while (free_count != 0) {
      if (waiting_ == 0) {
        if (next == rays.size()) return;
        prepare(rays, next);
        for (uint32_t apart = in_plane_; apart != 0; apart &= apart - 1)
          trace_alone(rays, first_prepared_ + static_cast<uint32_t>(std::countr_zero(apart)), finish);
        continue;
      }
      const auto i = static_cast<uint32_t>(std::countr_zero(waiting_));
      waiting_ &= waiting_ - 1;
      Slot& slot = *free_[--free_count];
      std::memcpy(&slot.at, &prepared_[i], sizeof(PreparedRay));
      slot.best.primitive = kNoId;
      slot.ray = static_cast<uint32_t>(first_prepared_ + i);
      slot.child = tree_.root;
      slot.top = 1;
      slot.stack[0].enter[0] = std::numeric_limits<float>::quiet_NaN();
      slot.stack[0].child[0] = tree_.root; // only prefetched
      slot.stack[0].rest = 1;
      queue[count++] = &slot;
    }
  }

  // Rays that may_lie_in_plane() visit cells in another order than frames have it.
  template <class Finish>
  void trace_alone(std::span<const Ray> rays, size_t i, const Finish& finish) {
    TreeHit best;
    float t_far = rays[i].t_max;
    const CandidateFilter filter{filter_, rays[i], tree_, kNoId};
    if (trace_tree<kAny>(tree_, rays[i], std::max(rays[i].t_min, 0.0f), filter, t_far, best)) finish(i, best);
  }

  // The next sixteen rays, or as many as there are; those that can hit something are then waiting.
  void prepare(std::span<const Ray> rays, size_t& next) {
    const auto count = static_cast<uint32_t>(std::min<size_t>(kRayLanes, rays.size() - next));
    RayLanes lanes;
    lanes.load(count, [&](uint32_t i) -> const Ray& { return rays[next + i]; });
    first_prepared_ = next;
    next += count;
    Float16 enter = Float16::load(lanes.t_min), leave = Float16::load(lanes.t_max);
    const Float16 zero(0.0f), one(1.0f), near = enter, far = leave;
    Float16 reciprocal[3];
    for (int k = 0; k < 3; ++k) { // as clip_to_box()
      const Float16 origin = Float16::load(lanes.origin[k]), direction = Float16::load(lanes.direction[k]);
      reciprocal[k] = one / direction;
      const uint32_t down = sign_bits(direction);
      const Float16 low(tree_.clip_bounds.min[k]), high(tree_.clip_bounds.max[k]);
      enter = max((select(down, low, high) - origin) * reciprocal[k], enter);
      leave = min((select(down, high, low) - origin) * reciprocal[k], leave);
    }
    const uint32_t enters = lanes.can_hit() & at_most(enter, leave * Float16(kWiden)) & ((1U << count) - 1U);
    in_plane_ = enters & lanes.may_lie_in_plane();
    waiting_ = enters & ~in_plane_;
    enter = min(enter, leave);
    const RayLanes::LargestAxis largest = lanes.largest_axis();
    const auto rotate = [&](const Float16& if_x, const Float16& if_y, const Float16& if_z) {
      return select(largest.x, select(largest.y, if_z, if_y), if_x);
    };
    const Float16 x = Float16::load(lanes.direction[0]), y = Float16::load(lanes.direction[1]),
                  z = Float16::load(lanes.direction[2]), dz = rotate(x, y, z);
    const Float16 axes = rotate(Float16(std::bit_cast<float>(0x000201U)), Float16(std::bit_cast<float>(0x010002U)),
                                Float16(std::bit_cast<float>(0x020100U)));
    const auto lane = [](size_t offset) { return offset / sizeof(float); };
    scatter(lanes.origin, near, lane(offsetof(PreparedRay, origin)));
    const Float16 shear[3] = {rotate(y, z, x) / dz, rotate(z, x, y) / dz, one / dz};
    scatter(reciprocal, far, lane(offsetof(PreparedRay, reciprocal)));
    scatter(shear, axes, lane(offsetof(PreparedRay, shear)));
    const Float16 interval[3] = {enter, leave, zero};
    scatter(interval, zero, lane(offsetof(PreparedRay, enter)));
  }
  // Writes four lanes of sixteen rays to a quad of each.
  void scatter(const float (&xyz)[3][kRayLanes], const Float16& w, size_t place) {
    alignas(64) float last[kRayLanes];
    w.store(last);
    for (uint32_t i = 0; i < kRayLanes; i += 4) {
      std::array<float*, 4> out;
      for (uint32_t k = 0; k < 4; ++k) out[k] = reinterpret_cast<float*>(&prepared_[i + k]) + place;
      Quad quads[4];
      for (uint32_t k = 0; k < 3; ++k) std::memcpy(&quads[k], xyz[k] + i, sizeof(Quad));
      std::memcpy(&quads[3], last + i, sizeof(Quad));
      transpose(quads[0], quads[1], quads[2], quads[3], out);
    }
  }
  void scatter(const Float16 (&xyz)[3], const Float16& w, size_t place) {
    alignas(64) float stored[3][kRayLanes];
    for (uint32_t k = 0; k < 3; ++k) xyz[k].store(stored[k]);
    scatter(stored, w, place);
  }

  [[nodiscard]] static RayShear shear_of_slot(const Slot& slot) {
    const uint32_t kx = slot.at.axes & 3U, ky = (slot.at.axes >> 8) & 3U, kz = slot.at.axes >> 16;
    RayShear shear;
    shear.kx = static_cast<int>(kx);
    shear.ky = static_cast<int>(ky);
    shear.kz = static_cast<int>(kz);
    shear.sx = slot.at.shear[0];
    shear.sy = slot.at.shear[1];
    shear.sz = slot.at.shear[2];
    const float* origin = slot.at.origin.data();
    shear.origin = {origin[kx], origin[ky], origin[kz]};
    return shear;
  }

  // b where the condition holds, else a; never a branch.
  static uint32_t select_bits(bool condition, uint32_t a, uint32_t b) {
    const uint32_t mask = 0U - static_cast<uint32_t>(condition);
    return a ^ ((a ^ b) & mask);
  }

  // Puts a ray at a cell, [enter, leave] cut to the end of the ray, and into the queue of its kind.
  void visit(Slot& slot, ChildWord child, float enter, float leave, Counts& counts) {
    const float t_far = slot.at.t_far;
    slot.child = child;
    slot.at.enter = enter;
    slot.at.leave = leave < t_far ? leave : t_far;
    const uint32_t alive = enter <= t_far ? 1 : 0;
    const uint32_t leaf = child >> 31;
    const auto node_at = reinterpret_cast<uintptr_t>(tree_.nodes.data()) + size_t{child} * sizeof(WideNode);
    const auto block_at =
        reinterpret_cast<uintptr_t>(tree_.leaves.data()) + size_t{child & ~kLeafBit} * sizeof(LeafUnit);
    const uintptr_t first = node_at ^ ((node_at ^ block_at) & (uintptr_t{0} - leaf)), line = uintptr_t{leaf} << 6;
    for (uintptr_t i = 0; i < kBlockLines; ++i) prefetch(reinterpret_cast<const void*>(first + i * line));
    node_[counts.node] = &slot;
    counts.node += alive & (leaf ^ 1);
    leaf_[counts.leaf] = &slot;
    counts.leaf += alive & leaf;
    done_[counts.done] = &slot;
    counts.done += alive ^ 1;
  }

  // One wide node down for every ray at a node. In three passes, each short enough for the processor to overlap many rays: one
  // ray's chain of dependent operations through all three is longer than what it can look ahead.
  void descend(Counts& total) {
    std::array<uint8_t, kStreamSlots> signs, entered;
    for (uint32_t k = 0; k < total.node; ++k) {
      Slot& slot = *node_[k];
      const WideNode& node = tree_.nodes[slot.child];
      const Int8 axes = shift_by_lane(Int8(std::bit_cast<uint32_t>(node.planes[kAxesLane])));
      const Float8 reciprocal = permute(Float8::load_twice(slot.at.reciprocal.data()), axes);
      const Float8 origin = permute(Float8::load_twice(slot.at.origin.data()), axes);
      ((Float8::load(node.planes.data()) - origin) * reciprocal).store(slot.t.data());
      signs[k] = static_cast<uint8_t>(sign_bits(reciprocal));
    }
    for (uint32_t k = 0; k < total.node; ++k) {
      Slot& slot = *node_[k];
      const Float8 t = Float8::load(slot.t.data());
      const Int8 order = Int8::from_bytes(tables::kNearFirst[signs[k]]);
      const Float8 t1 = broadcast_lane<kRootLane>(t), t2 = permute(t, shift_right<6>(order)),
                   t3 = permute(t, shift_right<3>(order));
      // In this order lanes 4 to 7 are on the far side of the root's plane, and so on.
      const Float8 enter = max_where<0xaa>(max_where<0xcc>(max_where<0xf0>(Float8(slot.at.enter), t1), t2), t3);
      const Float8 leave = min_where<0x55>(min_where<0x33>(min_where<0x0f>(Float8(slot.at.leave), t1), t2), t3);
      const Int8 children = permute(Int8::load(tree_.nodes[slot.child].child.data()), order);
      Frame& frame = slot.stack[slot.top];
      enter.store(frame.enter.data());
      leave.store(frame.leave.data());
      children.store(frame.child.data());
      entered[k] = static_cast<uint8_t>(at_most(enter, leave * Float8(kWiden)) & nonzero_bits(children));
    }
    Counts counts = total;
    counts.node = 0; // the queue is rewritten behind the place where it is read
    for (uint32_t k = 0; k < total.node; ++k) {
      Slot& slot = *node_[k];
      // The first child of the new frame or, if the ray enters none, the next of the topmost one.
      const uint32_t top = slot.top, below = slot.stack[top - 1].rest;
      const bool descends = entered[k] != 0;
      const uint32_t rest = select_bits(descends, below, entered[k]);
      const auto next = static_cast<uint32_t>(std::countr_zero(rest)) & (kWideLanes - 1);
      Frame& frame = slot.stack[top - 1 + static_cast<uint32_t>(descends)];
      const uint32_t left = rest & (rest - 1);
      frame.rest = left;
      slot.top = top + static_cast<uint32_t>(descends) - static_cast<uint32_t>(left == 0);
      visit(slot, frame.child[next], frame.enter[next], frame.leave[next], counts);
    }
    total = counts;
  }

  void test_leaves(std::span<const Ray> rays, Counts& total) {
    std::array<uint16_t, kStreamSlots> hit;        // bit i: triangle i is hit
    std::array<uint8_t, kStreamSlots + 1> hitting; // those with any, kAny: that the filter is to be asked about
    uint32_t hitting_count = 0;
    for (uint32_t k = 0; k < total.leaf; ++k) {
      const Slot& slot = *leaf_[k];
      const LeafBlock block = tree_.leaf_block(slot.child);
      const uint32_t mask = test_block(block, slot, tested_[k]);
      hit[k] = static_cast<uint16_t>(mask);
      hitting[hitting_count] = static_cast<uint8_t>(k);
      hitting_count += (kAny ? mask & block.asking() : mask) != 0 ? 1 : 0;
    }
    for (uint32_t i = 0; i < hitting_count; ++i)
      take_hits(rays, *leaf_[hitting[i]], tested_[hitting[i]], hit[hitting[i]]);
    Counts counts = total;
    counts.leaf = 0;
    for (uint32_t k = 0; k < total.leaf; ++k) {
      Slot& slot = *leaf_[k];
      const LeafBlock block = tree_.leaf_block(slot.child);
      if (kAny) {
        const bool ends = (hit[k] & ~block.asking()) != 0;
        slot.at.t_far = std::bit_cast<float>(
            select_bits(ends, std::bit_cast<uint32_t>(slot.at.t_far), std::bit_cast<uint32_t>(-1.0f)));
        slot.best.primitive &= ~(0U - static_cast<uint32_t>(ends));
      }
      // The next child of the topmost frame, unless the leaf goes on: what is left of it is one more cell, which only the end of the
      // ray keeps from being visited.
      const bool goes_on = !block.is_last();
      Frame& frame = slot.stack[slot.top - 1];
      const uint32_t rest = frame.rest, left = rest & (rest - 1);
      const auto next = static_cast<uint32_t>(std::countr_zero(rest)) & (kWideLanes - 1);
      frame.rest = select_bits(goes_on, left, rest);
      slot.top -= static_cast<uint32_t>(left == 0) & static_cast<uint32_t>(!goes_on);
      const uint32_t enter = select_bits(goes_on, std::bit_cast<uint32_t>(frame.enter[next]), 0);
      visit(slot, select_bits(goes_on, frame.child[next], slot.child + block.unit_count()), std::bit_cast<float>(enter),
            frame.leave[next], counts);
    }
    total = counts;
  }

  // Which triangles of a block the ray hits in its interval. Distances are computed before it is known whether they are
  // needed, so that there is no branch.
  static uint32_t test_block(const LeafBlock& block, const Slot& slot, TestedBlock& out) {
    const RayShear shear = shear_of_slot(slot);
    const ShearedVertices vertices(block, shear);
    uint32_t hit = 0;
    for_each_group(block, [&](uint32_t first, uint32_t count) {
      const TriangleTest test(vertices, block.corners() + first, count);
      const WideFloat t = test.distance(vertices, shear.sz);
      if (!kAny) out.store(first, t, test);
      hit |= (test.inside & above(t, WideFloat(slot.at.t_min)) & at_most(t, WideFloat(slot.at.t_far))) << first;
      return false;
    });
    if (kAny && (hit & block.asking()) != 0) [[unlikely]]
      for_each_group(block, [&](uint32_t first, uint32_t count) {
        const TriangleTest test(vertices, block.corners() + first, count);
        out.store(first, test.distance(vertices, shear.sz), test);
        return false;
      });
    return hit;
  }

  // Out of line: one or two times per ray.
  void take_hits(std::span<const Ray> rays, Slot& slot, const TestedBlock& tested, uint32_t hit) {
    const CandidateFilter filter{filter_, rays[slot.ray], tree_, kNoId};
    if (take_candidates<kAny>(tree_.leaf_block(slot.child), hit, tested, filter, slot.at.t_far, slot.best))
      slot.at.t_far = -1.0f;
  }

  const Tree& tree_;
  const HitFilter& filter_;
  Queue node_, leaf_, done_, free_;
  std::array<TestedBlock, kStreamSlots> tested_;
  std::array<PreparedRay, kRayLanes> prepared_; // rays from first_prepared_ on
  uint32_t waiting_ = 0;                        // bit i: prepared ray i has no slot yet
  uint32_t in_plane_ = 0;                       // bit i: prepared ray i goes alone
  size_t first_prepared_ = 0;
  alignas(64) std::array<std::byte, kStreamSlots * sizeof(Slot)> slots_;
};

} // namespace kindling::accel::kd::KINDLING_SIMD
