// Many independent rays through one tree at once: while one waits for memory or for its own arithmetic, the others go on.
//
// Each ray has a slot with its state and its own stack. A round takes every ray that stands at a node one wide node down, then
// every ray that stands at a leaf through it, then hands out the finished ones and refills their slots. A ray moves on by popping
// its stack, and enters the queue for nodes, for leaves or for finished rays by adding comparisons to the three counters: there is
// no branch to predict but that a triangle is hit. Every ray sees the cells in the order of trace_tree() and does its
// arithmetic, so that its answer is the same bit for bit, whatever its company.
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

// About 70 KB, meant for the stack; nothing is initialized before it is used.
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
  struct alignas(64) Slot {
    std::array<float, 4> origin, direction, reciprocal; // lane 3 of these is never selected
    RayShear shear;
    float t_min, t_far; // t_far is -1 once any hit will do
    TreeHit best;
    uint32_t ray;
    uint32_t top;
    ChildWord child; // where the ray stands, and its interval there
    float enter, leave;
    TraversalStack stack;
    std::array<std::byte, 64> spare;

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
      std::memcpy(slot.direction.data(), &direction, sizeof(Quad));
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
      slot.stack.enter[0] = std::numeric_limits<float>::quiet_NaN();
      slot.stack.child[0] = tree_.root; // only prefetched
      slot.child = tree_.root;
      queue[count] = &slot;
      count += enters;
      free_count -= enters;
    }
    (root_is_leaf ? counts.leaf : counts.node) = count;
  }

  // The topmost cell on the stack of a ray, and the queue that it belongs to.
  void pop(Slot& slot, uint32_t top, Counts& counts) {
    --top;
    const ChildWord child = slot.stack.child[top];
    const float enter = slot.stack.enter[top], leave = slot.stack.leave[top], t_far = slot.t_far;
    slot.top = top;
    slot.child = child;
    slot.enter = enter;
    slot.leave = leave < t_far ? leave : t_far;
    const uint32_t alive = enter <= t_far ? 1 : 0;
    const uint32_t leaf = child >> 31;
    const auto node_at = reinterpret_cast<uintptr_t>(tree_.nodes.data()) + size_t{child} * sizeof(WideNode);
    const auto block_at =
        reinterpret_cast<uintptr_t>(tree_.leaves.data()) + size_t{child & ~kLeafBit} * sizeof(LeafUnit);
    prefetch(reinterpret_cast<const void*>(node_at ^ ((node_at ^ block_at) & (uintptr_t{0} - leaf))));
    node_[counts.node] = &slot;
    counts.node += alive & (leaf ^ 1);
    leaf_[counts.leaf] = &slot;
    counts.leaf += alive & leaf;
    done_[counts.done] = &slot;
    counts.done += alive ^ 1;
  }

  void descend(Counts& total) {
    Counts counts = total;
    counts.node = 0; // the queue is rewritten behind the place where it is read
    for (uint32_t k = 0; k < total.node; ++k) {
      Slot& slot = *node_[k];
      const Float8 origin = Float8::load_twice(slot.origin.data());
      const Float8 point = origin + Float8(slot.enter) * Float8::load_twice(slot.direction.data());
      uint32_t top = slot.top;
      const WideStep step = step_down(tree_.nodes[slot.child], origin, Float8::load_twice(slot.reciprocal.data()),
                                      point, slot.enter, slot.leave, slot.stack, top);
      top += step.pushed;
      slot.stack.child[top] = step.child;
      slot.stack.enter[top] = slot.enter;
      slot.stack.leave[top] = step.leave;
      top += step.child != kEmptyChild ? 1 : 0;
      pop(slot, top, counts);
    }
    total = counts;
  }

  void test_leaves(std::span<const Ray> rays, Counts& total) {
    for (uint32_t k = 0; k < total.leaf; ++k) { // the first lines were fetched when the leaf was popped
      const auto* block = reinterpret_cast<const std::byte*>(tree_.leaves.data() + (leaf_[k]->child & ~kLeafBit));
      for (size_t line = 1; line < kBlockLines; ++line) prefetch(block + 64 * line);
    }
    Counts counts = total;
    counts.leaf = 0;
    for (uint32_t k = 0; k < total.leaf; ++k) {
      Slot& slot = *leaf_[k];
      const ChildWord child = slot.child;
      const LeafBlock block = tree_.leaf_block(child);
      test_block(block, rays, slot);
      // What is left of the leaf is one more cell, which only the end of the ray keeps from being visited.
      uint32_t top = slot.top;
      slot.stack.child[top] = child + block.unit_count();
      slot.stack.enter[top] = 0.0f;
      slot.stack.leave[top] = 0.0f;
      top += block.is_last() ? 0 : 1;
      pop(slot, top, counts);
    }
    total = counts;
  }

  // Same outcome as intersect_leaf() for one block. Distances are computed before it is known whether they are needed, so that
  // only hits in the ray's interval, one or two per ray, are a branch; and no hit is, where any will do.
  void test_block(const LeafBlock& block, std::span<const Ray> rays, Slot& slot) {
    const ShearedVertices vertices(block, slot.shear);
    const uint32_t asking = kAny ? block.asking() : 0;
    for_each_group(block, [&](uint32_t first, uint32_t count) {
      const TriangleTest test(vertices, block.corners() + first, count);
      const WideFloat t = test.distance(vertices, slot.shear.sz);
      const uint32_t mask = test.inside & above(t, WideFloat(slot.t_min)) & at_most(t, WideFloat(slot.t_far));
      if (kAny && (mask & (asking >> first)) == 0) {
        slot.t_far = mask != 0 ? -1.0f : slot.t_far;
        slot.best.primitive = mask != 0 ? 0 : slot.best.primitive;
      } else if (mask != 0) {
        const CandidateFilter filter{filter_, rays[slot.ray], tree_, kNoId};
        if (take_candidates<kAny>(block, first, mask, t, test, filter, slot.t_far, slot.best)) slot.t_far = -1.0f;
      }
      return false;
    });
  }

  static Quad quad_of(const Imath::V3f& v) { return Quad{v.x, v.y, v.z, 0.0f}; }

  const Tree& tree_;
  const HitFilter& filter_;
  Queue node_, leaf_, done_, free_;
  alignas(64) std::array<std::byte, kStreamSlots * sizeof(Slot)> slots_;
};

} // namespace kindling::accel::kd::KINDLING_SIMD
