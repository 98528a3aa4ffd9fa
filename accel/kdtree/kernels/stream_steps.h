// Steps of streams: many rays in flight, each down one node or through one block at a time.
//
// While one ray waits for memory or for its own arithmetic, the others proceed. Each ray has a slot
// with its state and its own stack. A step down leaves a frame on the stack: the children in the
// order of the ray, where it enters their boxes, and a bit for each that it enters. A ray continues
// with the first bit of its topmost frame; then all rays are sorted at once, by comparisons and
// compression, into those at nodes, at leaves and finished. The only branch to predict is whether a
// triangle is hit.
//
// Every step is split into passes over all rays: one ray's chain of dependent operations through a
// whole step exceeds a processor's look-ahead, while a short pass overlaps many rays.
//
// A ray's path and result depend on nothing but itself. Its arithmetic is that of trace_tree().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/stream_rays.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Smaller batches are faster as single rays.
inline constexpr size_t kMinStreamRays = 4;
// Number of cache lines prefetched of a leaf block; a full one has five.
inline constexpr size_t kBlockLines = 4;

// Takes hits of the nearest-hit or any-hit query. The other kind, for every hit, has
// take(ray, block, shear, t_min, t_far), which returns false to end the ray, and leave_aside(ray).
struct BestHits {};

// The trees that rays go through: one for all.
struct OneTree {
  // Number of rays in flight. More rays hide more latency until their stacks no longer fit into the
  // first-level cache.
  static constexpr uint32_t kSlots = 48;
  struct Place {};

  [[nodiscard]] const BoxNode* nodes(Place) const { return tree.nodes.data(); }
  [[nodiscard]] const LeafUnit* leaves(Place) const { return tree.leaves.data(); }
  [[nodiscard]] CandidateFilter filter(const HitFilter& filter, const Ray& ray, Place) const {
    return {filter, ray, tree, kNoId};
  }

  const Tree& tree;
};

// Takes 130 KB with one tree, meant for the stack; nothing is initialized before its use.
template <bool kAny, class Trees, class Hits>
class StreamSteps {
 public:
  StreamSteps(const StreamSteps&) = delete;
  StreamSteps& operator=(const StreamSteps&) = delete;

 protected:
  static constexpr bool kEvery = !std::is_same_v<Hits, BestHits>;
  static constexpr uint32_t kSlots = Trees::kSlots;

  StreamSteps(const Trees& trees, const HitFilter& filter, Hits hits) : trees_(trees), filter_(filter), hits_(hits) {}

  // The children of one node, nearest first or, for any hit, farthest first.
  struct alignas(64) Frame {
    std::array<float, kWideLanes> enter;
    std::array<ChildWord, kWideLanes> child;
  };
  static_assert(sizeof(Frame) == 64);
  static constexpr size_t kFrames = kMaxWideDepth + 2; // the lowest ends the ray; a step may write one above the top
  struct alignas(64) Slot {
    StreamRay at;
    float u, v; // of the best hit, which is at at.t_far
    uint32_t primitive;
    uint32_t ray;
    [[no_unique_address]] typename Trees::Place place;
    std::array<uint16_t, kFrames> rest; // by frame; bits i and i + 8: child i is still to be visited
    std::array<Frame, kFrames> stack;

    [[nodiscard]] TreeHit best() const { return {at.t_far, u, v, primitive}; }
  };
  static_assert(kFrames <= std::numeric_limits<decltype(StreamRay::top)>::max());
  // The size is an odd number of cache lines, so that the same place in different slots does not
  // map to the same cache set.
  static_assert(sizeof(Slot) / 64 % 2 == 1);
  // Slots are addressed by their offset in bytes; compression writes up to kLanes past the end.
  using Offsets = std::array<uint32_t, kSlots + kLanes>;
  // Rays at nodes or at leaves: slot, child, where they enter it, and where they end.
  struct Queue {
    alignas(64) Offsets slot;
    alignas(64) std::array<ChildWord, kSlots + kLanes> child;
    alignas(64) std::array<float, kSlots + kLanes> enter, far;
    uint32_t count = 0;
  };

  Slot& slot(uint32_t offset) { return *reinterpret_cast<Slot*>(slots_.data() + offset); }
  [[nodiscard]] LeafBlock block_of(const Slot& s, ChildWord leaf) const {
    assert((leaf & kLeafBit) != 0);
    return LeafBlock(trees_.leaves(s.place) + (leaf & ~kLeafBit));
  }

  void free_all_slots() {
    for (uint32_t s = 0; s < kSlots; ++s) free_[s] = s * static_cast<uint32_t>(sizeof(Slot));
    free_count_ = kSlots;
  }
  // Puts prepared rays into free slots while there are both. prepare() prepares rays of `count`
  // from `next_` on, which it advances, and sets `waiting_`; begin(offset, i) takes up prepared ray
  // i in the slot at `offset`, whose `at` is set.
  template <class Prepare, class Begin>
  void fill(size_t count, const Prepare& prepare, const Begin& begin) {
    while (free_count_ != 0) {
      if (waiting_ == 0) {
        if (next_ == count) return;
        prepare();
        continue;
      }
      const auto i = static_cast<uint32_t>(std::countr_zero(waiting_));
      waiting_ &= waiting_ - 1;
      const uint32_t offset = free_[--free_count_];
      slot(offset).at = prepared_.rays[i];
      begin(offset, i);
    }
  }

  // Puts the ray of a slot, whose `at`, `ray` and `place` are set, at the root of a tree.
  void begin_tree(uint32_t offset, ChildWord root) {
    Slot& s = slot(offset);
    s.primitive = kNoId;
    s.at.top = 1;
    s.stack[0].enter[0] = std::numeric_limits<float>::quiet_NaN();
    s.stack[0].child[0] = root; // never visited, only prefetched
    s.rest[0] = 1;
    Queue& queue = (root & kLeafBit) != 0 ? at_leaf_ : at_node_;
    assert(queue.count < kSlots);
    queue.slot[queue.count] = offset;
    queue.child[queue.count++] = root;
  }

  // Selects b if the condition holds, else a, without a branch.
  static uint32_t select_bits(bool condition, uint32_t a, uint32_t b) {
    const uint32_t mask = 0U - static_cast<uint32_t>(condition);
    return a ^ ((a ^ b) & mask);
  }

  // Sorts the first `count` rays of a queue after a step: those at nodes go to one queue from
  // position `nodes` on, those at leaves to another from position `leaves` on, the others to a
  // list. A queue may be sorted into itself from its beginning.
  static void sort(const Queue& from, uint32_t count, Queue& at_node, uint32_t& nodes, Queue& at_leaf, uint32_t& leaves,
                   Offsets& ended, uint32_t& ends) {
    for (uint32_t k = 0; k < count; k += kLanes) {
      const WideIntLanes slots = WideIntLanes::load(&from.slot[k]), child = WideIntLanes::load(&from.child[k]);
      const WideLanes enter = WideLanes::load(&from.enter[k]), far = WideLanes::load(&from.far[k]);
      const uint32_t used = count - k < kLanes ? (1U << (count - k)) - 1U : ~0U >> (32 - kLanes);
      const uint32_t alive = at_most(enter, far) & used, leaf = top_bits(child);
      const CompressWide to_nodes(alive & ~leaf), to_leaves(alive & leaf), to_ended(used & ~alive);
      to_nodes(slots).store(&at_node.slot[nodes]);
      to_nodes(child).store(&at_node.child[nodes]);
      to_leaves(slots).store(&at_leaf.slot[leaves]);
      to_leaves(child).store(&at_leaf.child[leaves]);
      to_ended(slots).store(&ended[ends]);
      nodes += static_cast<uint32_t>(std::popcount(alive & ~leaf));
      leaves += static_cast<uint32_t>(std::popcount(alive & leaf));
      ends += static_cast<uint32_t>(std::popcount(used & ~alive));
    }
  }
  void sort(const Queue& from, uint32_t count) {
    sort(from, count, at_node_, at_node_.count, at_leaf_, at_leaf_.count, done_, done_count_);
  }
  void fetch_nodes(uint32_t first) {
    for (uint32_t k = first; k < at_node_.count; ++k) {
      const auto* node =
          reinterpret_cast<const std::byte*>(trees_.nodes(slot(at_node_.slot[k]).place) + at_node_.child[k]);
      for (size_t line = 0; line < sizeof(BoxNode) / 64; ++line) prefetch(node + 64 * line);
    }
  }
  void fetch_leaves(uint32_t first) {
    for (uint32_t k = first; k < at_leaf_.count; ++k) {
      const auto* block = reinterpret_cast<const std::byte*>(trees_.leaves(slot(at_leaf_.slot[k]).place) +
                                                             (at_leaf_.child[k] & ~kLeafBit));
      for (size_t line = 0; line < kBlockLines; ++line) prefetch(block + 64 * line);
    }
  }

  // Takes every ray at a node down by one node.
  void descend() {
    Queue& queue = at_node_;
    const uint32_t count = queue.count;
    std::array<uint16_t, kSlots> entered;
    for (uint32_t k = 0; k < count; ++k) {
      Slot& s = slot(queue.slot[k]);
      const BoxNode& node = trees_.nodes(s.place)[queue.child[k]];
      Lanes8 enter(s.at.t_min), leave(s.at.t_far); // not beyond, or enter might exceed queue.far
      for (size_t axis = 0; axis < 3; ++axis) {
        const Lanes8 origin(s.at.origin[axis]), reciprocal(s.at.reciprocal[axis]);
        const Lanes8 low = (Lanes8::load(node.low[axis].data()) - origin) * reciprocal,
                     high = (Lanes8::load(node.high[axis].data()) - origin) * reciprocal;
        enter = max(enter, min(low, high));
        leave = min(leave, max(low, high));
      }
      const uint32_t signs = (sign_bits(Lanes8::load_twice(s.at.reciprocal.data())) ^ (kAny ? 7U : 0U)) & 7U;
      const IntLanes8 order = shift_by_nibbles(IntLanes8(node.order[signs]));
      const IntLanes8 children = permute(IntLanes8::load(node.child.data()), order);
      enter = permute(enter, order);
      leave = permute(leave, order);
      assert(s.at.top < s.stack.size());
      Frame& frame = s.stack[s.at.top];
      enter.store(frame.enter.data());
      children.store(frame.child.data());
      const uint32_t all = at_most(enter, leave * Lanes8(kWiden));
      // For any hit, nodes come before leaves, in the lower bits: they are larger and hold more.
      const uint32_t later = kAny ? all & top_bits(children) : 0;
      entered[k] = static_cast<uint16_t>((all ^ later) | later << kWideLanes);
    }
    for (uint32_t k = 0; k < count; ++k) {
      // Continues with the first child of the new frame or, if the ray enters none, the next child
      // of the topmost one.
      Slot& s = slot(queue.slot[k]);
      const uint32_t top = s.at.top;
      const bool descends = entered[k] != 0;
      const uint32_t rest = select_bits(descends, s.rest[top - 1], entered[k]), left = rest & (rest - 1);
      const auto next = static_cast<uint32_t>(std::countr_zero(rest)) & (kWideLanes - 1);
      const size_t at = top - 1 + static_cast<size_t>(descends);
      s.rest[at] = static_cast<uint16_t>(left);
      queue.child[k] = s.stack[at].child[next];
      queue.enter[k] = s.stack[at].enter[next];
      queue.far[k] = s.at.t_far * kBeyond;
      s.at.top = static_cast<uint8_t>(top + static_cast<uint32_t>(descends) - static_cast<uint32_t>(left == 0));
    }
    const uint32_t old_leaves = at_leaf_.count;
    at_node_.count = 0; // rewritten behind the read position
    sort(queue, count);
    fetch_leaves(old_leaves);
    fetch_nodes(0);
  }

  // Tests one block of its leaf for every ray at a leaf.
  void test_leaves(std::span<const Ray> rays) {
    Queue& queue = at_leaf_;
    const uint32_t count = queue.count;
    std::array<uint16_t, kSlots> hit;        // bit i: triangle i is hit
    std::array<ChildWord, kSlots> rest_of;   // next block of the leaf, or 0
    std::array<uint8_t, kSlots + 1> hitting; // rays with hits or, if kAny, with hits that the filter decides
    uint32_t hitting_count = 0;
    for (uint32_t k = 0; k < count; ++k) {
      Slot& s = slot(queue.slot[k]);
      const LeafBlock block = block_of(s, queue.child[k]);
      const uint32_t mask = test_block(block, s.at, tested_[tested_place(k, hitting_count)]),
                     filtered = block.filtered();
      hit[k] = static_cast<uint16_t>(mask);
      const uint32_t next = block.units_to_next();
      rest_of[k] = select_bits(next == 0, queue.child[k] + next, 0);
      hitting[hitting_count] = static_cast<uint8_t>(k);
      hitting_count += (kAny ? mask & filtered : mask) != 0 ? 1 : 0;
      if (kAny) {
        const bool ends = (mask & ~filtered) != 0;
        s.at.t_far = std::bit_cast<float>(
            select_bits(ends, std::bit_cast<uint32_t>(s.at.t_far), std::bit_cast<uint32_t>(-1.0f)));
        s.primitive &= ~(0U - static_cast<uint32_t>(ends));
      }
    }
    for (uint32_t i = 0; i < hitting_count; ++i) {
      const uint32_t k = hitting[i];
      take_hits(rays, slot(queue.slot[k]), queue.child[k], tested_[tested_place(k, i)], hit[k]);
    }
    for (uint32_t k = 0; k < count; ++k) {
      // Continues with the next block of the leaf, else with the next child of the topmost frame. A
      // next block is a further cell that is skipped only if the ray has ended.
      Slot& s = slot(queue.slot[k]);
      const bool continues = rest_of[k] != 0;
      const Frame& frame = s.stack[s.at.top - 1];
      const uint32_t rest = s.rest[s.at.top - 1], left = rest & (rest - 1);
      const auto next = static_cast<uint32_t>(std::countr_zero(rest)) & (kWideLanes - 1);
      s.rest[s.at.top - 1] = static_cast<uint16_t>(select_bits(continues, left, rest));
      s.at.top =
          static_cast<uint8_t>(s.at.top - (static_cast<uint32_t>(left == 0) & static_cast<uint32_t>(!continues)));
      queue.child[k] = select_bits(continues, frame.child[next], rest_of[k]);
      queue.enter[k] = std::bit_cast<float>(select_bits(continues, std::bit_cast<uint32_t>(frame.enter[next]), 0));
      queue.far[k] = s.at.t_far * kBeyond;
    }
    const uint32_t old_nodes = at_node_.count;
    at_leaf_.count = 0;
    sort(queue, count);
    fetch_nodes(old_nodes);
    fetch_leaves(0);
  }

  // Returns where the test of the k-th block is kept, the i-th of those with hits. Keeping only
  // those spares the first-level cache, and delays the address by the test before, which matters
  // more where tests are short.
  static uint32_t tested_place(uint32_t k, uint32_t i) { return kLanes == kBlockTriangles ? k : i; }

  // Returns a mask of the triangles of a block that the ray hits in its interval. Distances are
  // computed before it is known whether they are needed, which avoids a branch.
  [[gnu::always_inline]] static uint32_t test_block(const LeafBlock& block, const StreamRay& ray, TestedBlock& out) {
    const RayShear shear = ray.ray_shear();
    const ShearedVertices vertices(block, shear);
    uint32_t hit = 0;
    for_each_group(block, [&](uint32_t first, uint32_t count) {
      const TriangleTest test(vertices, block.corners() + first, count);
      const WideLanes t = test.distance(vertices, shear.sz);
      if (!kAny) out.store(first, t, test);
      hit |= (test.inside & above(t, WideLanes(ray.t_min)) & at_most(t, WideLanes(ray.t_far))) << first;
      return false;
    });
    if (kAny && (hit & block.filtered()) != 0) [[unlikely]]
      for_each_group(block, [&](uint32_t first, uint32_t count) {
        const TriangleTest test(vertices, block.corners() + first, count);
        out.store(first, test.distance(vertices, shear.sz), test);
        return false;
      });
    return hit;
  }

  // Accepts hits; called once or twice per ray.
  void take_hits(std::span<const Ray> rays, Slot& s, ChildWord leaf, const TestedBlock& tested, uint32_t hit) {
    if constexpr (kEvery) {
      if (!hits_.take(s.ray, block_of(s, leaf), s.at.ray_shear(), s.at.t_min, s.at.t_far)) s.at.t_far = -1.0f;
      return;
    }
    const CandidateFilter filter = trees_.filter(filter_, rays[s.ray], s.place);
    TreeHit best = s.best();
    if (take_candidates<kAny>(block_of(s, leaf), hit, tested, filter, s.at.t_far, best)) s.at.t_far = -1.0f;
    s.u = best.u;
    s.v = best.v;
    s.primitive = best.primitive;
  }

  Trees trees_;
  const HitFilter& filter_;
  [[no_unique_address]] Hits hits_;
  Queue at_node_, at_leaf_;
  alignas(64) Offsets done_, free_;
  uint32_t done_count_ = 0, free_count_ = 0;
  PreparedRays prepared_;
  size_t next_ = 0;      // index of the next ray to prepare
  uint32_t waiting_ = 0; // bit i: prepared ray i has no slot yet
  std::array<TestedBlock, kSlots> tested_;
  alignas(64) std::array<std::byte, kSlots * sizeof(Slot)> slots_;
};

} // namespace kindling::accel::kd::KINDLING_SIMD
