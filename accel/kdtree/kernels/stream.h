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
    const uint32_t slots = static_cast<uint32_t>(std::min<size_t>(rays.size(), kStreamSlots));
    for (uint32_t s = 0; s < slots; ++s) free_[s] = reinterpret_cast<Slot*>(&slots_[s * sizeof(Slot)]);
    uint32_t free_count = slots;
    size_t next = 0;
    Counts counts;
    while (true) {
      if (free_count != 0 && next < rays.size()) fill(rays, next, free_count, counts);
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
  using IntQuad = int32_t __attribute__((vector_size(16)));
  // The children of one wide node, near ones first.
  struct alignas(64) Frame {
    std::array<float, kWideLanes> enter, leave;
    std::array<ChildWord, kWideLanes> child;
    uint32_t rest; // bit i: child i is still to be visited
  };
  static_assert(sizeof(Frame) == 128);
  struct alignas(64) Slot {
    std::array<float, 4> origin, reciprocal; // lane 3 of these is never selected
    std::array<float, 8> t;                  // distances of the planes of the node
    RayShear shear;
    float t_min, t_far; // t_far is -1 once any hit will do
    TreeHit best;
    uint32_t ray;
    uint32_t top;      // frames on the stack
    uint32_t in_plane; // may_lie_in_plane()
    ChildWord child;   // where the ray stands, and its interval there
    float enter, leave;
    std::array<Frame, kMaxWideDepth + 2> stack; // the lowest ends the ray; a step may write one above the top

    explicit Slot(uint32_t number) : ray(number) {}
  };
  // An odd number of cache lines: equal places of different slots do not compete for one set of the cache.
  static_assert(sizeof(Slot) / 64 % 2 == 1);
  static_assert(std::is_trivially_destructible_v<Slot>);
  using Queue = std::array<Slot*, kStreamSlots + 2>; // appending writes before it knows
  struct Counts {
    uint32_t node = 0, leaf = 0, done = 0;
  };

  // Puts rays into free slots; those that miss the box of the tree at once leave theirs to the next.
  void fill(std::span<const Ray> rays, size_t& next, uint32_t& free_count, Counts& counts) {
    const bool root_is_leaf = (tree_.root & kLeafBit) != 0;
    Queue& queue = root_is_leaf ? leaf_ : node_;
    uint32_t count = root_is_leaf ? counts.leaf : counts.node;
    const Quad low = quad_of(tree_.clip_bounds.min), high = quad_of(tree_.clip_bounds.max);
    for (; free_count != 0 && next < rays.size(); ++next) {
      const Ray& ray = rays[next];
      Slot& slot = *new (free_[free_count - 1]) Slot(static_cast<uint32_t>(next));
      const Quad origin = origin_quad(ray), direction = direction_quad(ray),
                 reciprocal = Quad{1.0f, 1.0f, 1.0f, 1.0f} / direction;
      std::memcpy(slot.origin.data(), &origin, sizeof(Quad));
      std::memcpy(slot.reciprocal.data(), &reciprocal, sizeof(Quad));
      slot.shear = shear_of(ray);
      // As in clip_to_box().
      const IntQuad down = std::bit_cast<IntQuad>(direction) < 0;
      const Quad t0 = ((down ? high : low) - origin) * reciprocal, t1 = ((down ? low : high) - origin) * reciprocal;
      float enter = std::max(ray.t_min, 0.0f), leave = ray.t_max;
      slot.t_min = enter;
      slot.t_far = leave;
      for (int k = 0; k < 3; ++k) {
        enter = t0[k] > enter ? t0[k] : enter;
        leave = t1[k] < leave ? t1[k] : leave;
      }
      const bool enters = can_hit(ray) & (enter <= leave * kWiden);
      slot.enter = enter < leave ? enter : leave;
      slot.leave = leave;
      slot.top = 1;
      slot.in_plane = may_lie_in_plane(ray.direction) ? 1 : 0;
      slot.stack[0].enter[0] = std::numeric_limits<float>::quiet_NaN();
      slot.stack[0].child[0] = tree_.root; // only prefetched
      slot.stack[0].rest = 1;
      slot.child = tree_.root;
      queue[count] = &slot;
      count += enters;
      free_count -= enters;
    }
    (root_is_leaf ? counts.leaf : counts.node) = count;
  }

  // Drops cells beyond the hit from the stack of a ray that may_lie_in_plane(), and returns how many frames are left.
  static uint32_t pass_over(Slot& slot, uint32_t top) {
    while (true) {
      Frame& frame = slot.stack[top - 1];
      if (!(frame.enter[static_cast<uint32_t>(std::countr_zero(frame.rest))] > slot.t_far))
        return top; // NaN: the lowest
      frame.rest &= frame.rest - 1;
      top -= frame.rest == 0 ? 1 : 0;
    }
  }

  // Takes the next cell from the stack of a ray, which has `top` frames, and puts it into the queue of its kind.
  void pop(Slot& slot, uint32_t top, Counts& counts) {
    if (slot.in_plane != 0) [[unlikely]]
      top = pass_over(slot, top);
    Frame& frame = slot.stack[top - 1];
    const uint32_t rest = frame.rest;
    const auto next = static_cast<uint32_t>(std::countr_zero(rest)) & (kWideLanes - 1);
    const ChildWord child = frame.child[next];
    const float enter = frame.enter[next], leave = frame.leave[next], t_far = slot.t_far;
    const uint32_t left = rest & (rest - 1);
    frame.rest = left;
    slot.top = top - (left == 0 ? 1 : 0);
    slot.child = child;
    slot.enter = enter;
    slot.leave = leave < t_far ? leave : t_far;
    const uint32_t alive = enter <= t_far ? 1 : 0;
    const uint32_t leaf = child >> 31;
    const auto node_at = reinterpret_cast<uintptr_t>(tree_.nodes.data()) + size_t{child} * sizeof(WideNode);
    const auto block_at =
        reinterpret_cast<uintptr_t>(tree_.leaves.data()) + size_t{child & ~kLeafBit} * sizeof(LeafUnit);
    prefetch(reinterpret_cast<const void*>(node_at ^ ((node_at ^ block_at) & (uintptr_t{0} - leaf)))); // no branch
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
      const Float8 reciprocal = permute(Float8::load_twice(slot.reciprocal.data()), axes);
      const Float8 origin = permute(Float8::load_twice(slot.origin.data()), axes);
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
      const Float8 enter = max_where<0xaa>(max_where<0xcc>(max_where<0xf0>(Float8(slot.enter), t1), t2), t3);
      const Float8 leave = min_where<0x55>(min_where<0x33>(min_where<0x0f>(Float8(slot.leave), t1), t2), t3);
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
      const uint32_t top = slot.top;
      slot.stack[top].rest = entered[k];
      pop(slot, top + (entered[k] != 0 ? 1 : 0), counts);
    }
    total = counts;
  }

  void test_leaves(std::span<const Ray> rays, Counts& total) {
    for (uint32_t k = 0; k < total.leaf; ++k) { // the first lines were fetched when the leaf was popped
      const auto* block = reinterpret_cast<const std::byte*>(tree_.leaves.data() + (leaf_[k]->child & ~kLeafBit));
      for (size_t line = 1; line < kBlockLines; ++line) prefetch(block + 64 * line);
    }
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
        slot.t_far = ends ? -1.0f : slot.t_far;
        slot.best.primitive = ends ? 0 : slot.best.primitive;
      }
      // What is left of the leaf is one more cell, which only the end of the ray keeps from being visited.
      uint32_t top = slot.top;
      Frame& frame = slot.stack[top];
      frame.child[0] = slot.child + block.unit_count();
      frame.enter[0] = 0.0f;
      frame.leave[0] = 0.0f;
      frame.rest = 1;
      top += block.is_last() ? 0 : 1;
      pop(slot, top, counts);
    }
    total = counts;
  }

  // Which triangles of a block the ray hits in its interval. Distances are computed before it is known whether they are
  // needed, so that there is no branch.
  static uint32_t test_block(const LeafBlock& block, const Slot& slot, TestedBlock& out) {
    const ShearedVertices vertices(block, slot.shear);
    uint32_t hit = 0;
    for_each_group(block, [&](uint32_t first, uint32_t count) {
      const TriangleTest test(vertices, block.corners() + first, count);
      const WideFloat t = test.distance(vertices, slot.shear.sz);
      if (!kAny) out.store(first, t, test);
      hit |= (test.inside & above(t, WideFloat(slot.t_min)) & at_most(t, WideFloat(slot.t_far))) << first;
      return false;
    });
    if (kAny && (hit & block.asking()) != 0) [[unlikely]]
      for_each_group(block, [&](uint32_t first, uint32_t count) {
        const TriangleTest test(vertices, block.corners() + first, count);
        out.store(first, test.distance(vertices, slot.shear.sz), test);
        return false;
      });
    return hit;
  }

  // Out of line: one or two times per ray.
  void take_hits(std::span<const Ray> rays, Slot& slot, const TestedBlock& tested, uint32_t hit) {
    const CandidateFilter filter{filter_, rays[slot.ray], tree_, kNoId};
    if (take_candidates<kAny>(tree_.leaf_block(slot.child), hit, tested, filter, slot.t_far, slot.best))
      slot.t_far = -1.0f;
  }

  static Quad quad_of(const Imath::V3f& v) { return Quad{v.x, v.y, v.z, 0.0f}; }

  const Tree& tree_;
  const HitFilter& filter_;
  Queue node_, leaf_, done_, free_;
  std::array<TestedBlock, kStreamSlots> tested_;
  alignas(64) std::array<std::byte, kStreamSlots * sizeof(Slot)> slots_;
};

} // namespace kindling::accel::kd::KINDLING_SIMD
