// Packet traversal: nearby rays of similar direction in lockstep, sixteen to a register.
//
// All rays of a packet have the same signs of direction, so that they agree on the near child of a
// plane, and the same largest axis, so that they shear triangles alike. A wide node is traversed
// plane by plane: a plane that all rays cross outside of their intervals costs one comparison for
// all of them. The interval of a ray that does not enter a cell is empty, stays empty further down,
// and needs no mask.
//
// Four registers, 8 x 8 pixels of camera rays, share the traversal, so that nodes are fetched,
// branches predicted and packets set up once for 64 rays. A register that enters a cell alone
// continues by itself, and so do, as in trace_tree(), its last one or two rays. Batches in which
// many shadow rays end up alone are faster in a stream, which the rest of the batch then uses: if
// more than one ray in four does, by experiment. Tried without gain for shadow rays, on few scenes
// and repetitions: packets of mixed signs, with near and far exchanged by masks (0 to 8 % slower);
// tracing the first register of a batch alone to detect incoherence earlier (no gain overall), and
// with it a threshold of one in eight (helps where rays scatter, hurts elsewhere).
//
// Distances to planes, intervals and triangle tests are those of trace_tree(), operation by
// operation. A ray may be taken through cells that it would not have entered alone, if only
// rounding kept it out; that changes no hit. Registers are sixteen wide on every target.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/packet_rays.h"

#include <utility>

namespace kindling::accel::kd::KINDLING_SIMD {

// Number of registers of rays that traverse the tree together.
inline constexpr uint32_t kPacketRegisters = 4;

template <bool kAny>
class Packet {
 public:
  Packet(const Tree& tree, const HitFilter& filter) : scene_{tree, filter} {}
  Packet(const Packet&) = delete;
  Packet& operator=(const Packet&) = delete;

  [[nodiscard]] PacketRays<kAny>& rays(uint32_t i) { return rays_[i]; }

  // Returns true if many of the rays traced since start_batch() have left their packets, so that a
  // stream is faster.
  [[nodiscard]] bool is_incoherent() const { return kAny && lone_ * 4 > traced_; }
  void start_batch() { lone_ = traced_ = 0; }

  // Traces the first kCount registers, whose rays must be of one class.
  template <uint32_t kCount>
  void trace() {
    Cell<kCount> cell;
    uint32_t enters = 0;
    traced_ += kCount * kRayLanes;
    for_each<kCount>([&](auto r) __attribute__((always_inline)) {
      rays_[r].prepare_shear();
      enters |= rays_[r].clip_to_bounds(scene_.tree.clip_bounds, cell.enter[r], cell.leave[r]);
    });
    for (uint32_t k = 0; k < 3; ++k) down_[k] = rays_[0].points_down(k) ? 1 : 0;
    for_each<kCount>([&](auto r) __attribute__((always_inline)) { cell.leave[r] = cell.leave[r] * Lanes16(kWiden); });
    if (enters != 0) walk<kCount>(rays_, cell, scene_.tree.root, 1);
  }

 private:
  // Calls f(0) to f(kCount - 1) with constants. Everything is inlined; otherwise the compiler would
  // keep cells in memory between steps.
  template <uint32_t kCount, class F>
  [[gnu::always_inline]] static void for_each(const F& f) {
    [&]<uint32_t... kIndex>(std::integer_sequence<uint32_t, kIndex...>) __attribute__((always_inline)) {
      (f(std::integral_constant<uint32_t, kIndex>()), ...);
    }
    (std::make_integer_sequence<uint32_t, kCount>());
  }
  // Intervals of the rays in a cell; empty for rays that do not enter it. `leave` is widened by
  // kWiden.
  template <uint32_t kCount>
  struct alignas(64) Cell {
    Lanes16 enter[kCount], leave[kCount];
  };
  template <uint32_t kCount>
  struct Entry {
    Cell<kCount> cell;
    ChildWord child;
    uint32_t heap;
  };
  template <uint32_t kCount>
  using Stack = std::array<Entry<kCount>, kMaxDepth + 1>;

  // Traverses from a cell on: plane `heap` of a wide node, or a leaf.
  template <uint32_t kCount>
  void walk(PacketRays<kAny>* rays, const Cell<kCount>& start, ChildWord child, uint32_t heap) {
    Cell<kCount> cell; // kept in registers
    for_each<kCount>([&](auto r) __attribute__((always_inline)) {
      cell.enter[r] = start.enter[r];
      cell.leave[r] = start.leave[r];
    });
    Entry<kCount>* const stack = stack_of<kCount>();
    uint32_t top = 0;
    while (true) {
      while (static_cast<int32_t>(child) > 0) {
        if (hand_over<kCount>(rays, cell, child, heap)) {
          child = kEmptyChild;
          break;
        }
        const WideNode& node = scene_.tree.nodes[child];
        heap = descend<kCount>(rays, node, child, heap, cell, stack, top);
        child = node.child[heap - kWideLanes];
        heap = 1;
      }
      if (child != kEmptyChild && test_leaf<kCount>(rays, child, cell)) return;
      Lanes16 end[kCount];
      for_each<kCount>([&](auto r) __attribute__((always_inline)) { end[r] = rays[r].end(); });
      uint32_t alive;
      do {
        if (top == 0) return;
        const Entry<kCount>& entry = stack[--top];
        alive = 0;
        for_each<kCount>([&](auto r) __attribute__((always_inline)) {
          cell.enter[r] = entry.cell.enter[r];
          cell.leave[r] = min(entry.cell.leave[r], end[r]);
          alive |= at_most(cell.enter[r], end[r]);
        });
        child = entry.child;
        heap = entry.heap;
      } while (alive == 0);
    }
  }

  // Maximum number of active rays in a register that continue one by one.
  static constexpr int kLoneRays = kAny ? 1 : 2;

  // If only one register's rays enter a cell or, with one register, few rays: traces them through
  // it and returns true. Also returns true if none enter.
  template <uint32_t kCount>
  [[gnu::always_inline]] bool hand_over(PacketRays<kAny>* rays, const Cell<kCount>& cell, ChildWord child,
                                        uint32_t heap) {
    if constexpr (kCount == 1) {
      const uint32_t active = at_most(cell.enter[0], cell.leave[0]);
      if (std::popcount(active) > kLoneRays) return false;
      alignas(64) float enter[kRayLanes], leave[kRayLanes];
      cell.enter[0].store(enter);
      min(cell.leave[0], rays[0].end()).store(leave); // slightly beyond the cell
      for (uint32_t rest = active; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<uint32_t>(std::countr_zero(rest));
        ++lone_;
        rays[0].trace_alone(scene_, i, child, enter[i], leave[i]);
      }
      return true;
    }
    uint32_t registers = 0;
    for_each<kCount>([&](auto r) __attribute__((always_inline)) {
      registers |= (at_most(cell.enter[r], cell.leave[r]) != 0 ? 1U : 0U) << r;
    });
    if ((registers & (registers - 1)) != 0) return false;
    for_each<kCount>([&](auto r) __attribute__((always_inline)) {
      if (registers == 1U << r) walk<1>(rays + r, Cell<1>{{cell.enter[r]}, {cell.leave[r]}}, child, heap);
    });
    return true;
  }

  // Descends from plane `heap` of a node to one of its children; returns the heap index of the
  // child.
  template <uint32_t kCount>
  [[gnu::always_inline]] uint32_t descend(const PacketRays<kAny>* rays, const WideNode& node, ChildWord number,
                                          uint32_t heap, Cell<kCount>& cell, Entry<kCount>* stack, uint32_t& top) {
    const uint32_t axes = std::bit_cast<uint32_t>(node.planes[kAxesLane]);
    do {
      const uint32_t lane = heap >= 4 ? heap : heap == 1 ? kRootLane : heap - 2;
      const float plane = node.planes[lane];
      const uint32_t axis = (axes >> (2 * lane)) & 3U;
      if (plane == std::numeric_limits<float>::infinity()) { // the branch ends above this plane
        heap *= 2;
        continue;
      }
      const Lanes16 at(plane);
      Lanes16 near_leave[kCount], far_enter[kCount];
      uint32_t to_near = 0, to_far = 0;
      for_each<kCount>([&](auto r) __attribute__((always_inline)) {
        const Lanes16 t = rays[r].distance(at, axis);
        near_leave[r] = min(t * Lanes16(kWiden), cell.leave[r]);
        far_enter[r] = max(t, cell.enter[r]);
        to_near |= at_most(cell.enter[r], near_leave[r]);
        to_far |= at_most(far_enter[r], cell.leave[r]);
      });
      const uint32_t near = 2 * heap + down_[axis], far = near ^ 1U;
      if (to_far == 0) {
        for_each<kCount>([&](auto r) __attribute__((always_inline)) { cell.leave[r] = near_leave[r]; });
        heap = near;
      } else if (to_near == 0) {
        for_each<kCount>([&](auto r) __attribute__((always_inline)) { cell.enter[r] = far_enter[r]; });
        heap = far;
      } else {
        // Nearest hits need the near child first. Shadow rays meet something more often in the far
        // one: near the surface that they leave there is little.
        const uint32_t first = kAny ? far : near, second = first ^ 1U;
        assert(top <= kMaxDepth);
        Entry<kCount>& entry = stack[top];
        const bool outside = second >= kWideLanes;
        entry.child = outside ? node.child[second & (kWideLanes - 1)] : number;
        entry.heap = outside ? 1 : second;
        top += entry.child != kEmptyChild ? 1 : 0;
        for_each<kCount>([&](auto r) __attribute__((always_inline)) {
          entry.cell.enter[r] = kAny ? cell.enter[r] : far_enter[r];
          entry.cell.leave[r] = kAny ? near_leave[r] : cell.leave[r];
          (kAny ? cell.enter[r] : cell.leave[r]) = kAny ? far_enter[r] : near_leave[r];
        });
        heap = first;
      }
    } while (heap < kWideLanes);
    return heap;
  }

  // Tests a leaf; returns true if all rays are done.
  template <uint32_t kCount>
  [[gnu::always_inline]] bool test_leaf(PacketRays<kAny>* rays, ChildWord child, const Cell<kCount>& cell) {
    const LeafUnit* unit = scene_.tree.leaves.data() + (child & ~kLeafBit);
    uint32_t active[kCount], all = 0; // rays of registers that are tested together
    for_each<kCount>([&](auto r) __attribute__((always_inline)) {
      active[r] = at_most(cell.enter[r], cell.leave[r]) & at_most(cell.enter[r], rays[r].end());
      if (active[r] != 0 && std::popcount(active[r]) < PacketRays<kAny>::kMinLeafRays) {
        rays[r].test_leaf(scene_, unit, active[r]);
        active[r] = 0;
      }
      all |= active[r];
    });
    while (all != 0) {
      const LeafBlock block(unit);
      uint32_t triangles[kCount]; // for all registers first, since the tests are full of mispredicted branches
      for_each<kCount>([&](auto r) __attribute__((always_inline)) { triangles[r] = rays[r].possible(block); });
      for_each<kCount>([&](auto r) __attribute__((always_inline)) {
        if (active[r] != 0 && triangles[r] != 0) rays[r].test_block(scene_, block, triangles[r], active[r]);
      });
      if (block.is_last()) break;
      unit += block.unit_count();
    }
    bool done = kAny;
    for_each<kCount>([&](auto r) __attribute__((always_inline)) {
      if (kAny) done = done && rays[r].is_done();
    });
    return done;
  }

  template <uint32_t kCount>
  Entry<kCount>* stack_of() {
    if constexpr (kCount == 1)
      return one_stack_.data();
    else
      return stack_.data();
  }

  typename PacketRays<kAny>::Scene scene_;
  uint32_t down_[3] = {0, 0, 0};   // by axis: 1 if all rays point in its negative direction
  uint32_t lone_ = 0, traced_ = 0; // counted since start_batch()
  PacketRays<kAny> rays_[kPacketRegisters];
  Stack<1> one_stack_;
  Stack<kPacketRegisters> stack_;
};

// Traces rays in packets: four registers at once in input order if their rays are of one class, the
// others sorted by class. Classes with few rays are passed to `rest`. Calls finish(ray index, hit)
// for each ray of a packet that hits something. Any hit: once more than a quarter of the rays have
// left their packets, all others of the batch go to `rest`.
template <bool kAny, class Finish, class Rest>
inline void trace_packets(const Tree& tree, const HitFilter& filter, std::span<const Ray> rays, const Finish& finish,
                          const Rest& rest) {
  constexpr size_t kMax = 256;           // rays sorted at once; their indices are stored in bytes
  constexpr uint32_t kMinPacketRays = 4; // minimum number of rays in a packet
  constexpr uint32_t kGroup = kPacketRegisters * kRayLanes;
  if (tree.root == kEmptyChild) return;
  Packet<kAny> packet(tree, filter);
  for (size_t first = 0; first < rays.size(); first += kMax) {
    const auto count = static_cast<uint32_t>(std::min(kMax, rays.size() - first));
    const Ray* part = &rays[first];
    const auto load = [&](uint32_t r, uint32_t size, const auto& ray_at) {
      if (size == kRayLanes)
        packet.rays(r).load(kRayLanes, ray_at); // a compile-time count
      else
        packet.rays(r).load(size, ray_at);
    };
    const auto deliver = [&](uint32_t r, const auto& number) {
      packet.rays(r).deliver([&](uint32_t i, const TreeHit& hit) { finish(first + number(i), hit); });
    };
    packet.start_batch();
    uint8_t classes[kMax], left[kMax]; // classes by ray index; indices of the rays left
    uint32_t left_count = 0;
    for (uint32_t k = 0; k < count; k += kGroup) {
      if (filter.abandoned()) return;
      const uint32_t registers = (std::min(kGroup, count - k) + kRayLanes - 1) / kRayLanes;
      const auto number = [&](uint32_t r) { return [k, r](uint32_t i) { return k + r * kRayLanes + i; }; };
      std::array<RayClasses, kPacketRegisters> found;
      CommonClass common;
      for (uint32_t r = 0; r < registers; ++r) {
        const Ray* at = part + k + r * kRayLanes;
        load(r, std::min(kRayLanes, count - k - r * kRayLanes), [at](uint32_t i) -> const Ray& { return at[i]; });
        found[r] = packet.rays(r).classes();
        common.add(found[r]);
      }
      if (count - k >= kGroup && common.agree() && !packet.is_incoherent()) {
        packet.template trace<kPacketRegisters>();
        for (uint32_t r = 0; r < kPacketRegisters; ++r) deliver(r, number(r));
        continue;
      }
      for (uint32_t r = 0; r < registers; ++r) found[r].store(&classes[k + r * kRayLanes]);
      for (uint32_t i = k; i < std::min(k + kGroup, count); ++i) left[left_count++] = static_cast<uint8_t>(i);
    }
    if (left_count == 0) continue;
    uint8_t order[kMax];
    std::array<uint16_t, kRayClasses + 1> start{};
    for (uint32_t i = 0; i < left_count; ++i) ++start[classes[left[i]] + 1U];
    for (uint32_t c = 0; c < kRayClasses; ++c) start[c + 1] = static_cast<uint16_t>(start[c + 1] + start[c]);
    std::array<uint16_t, kRayClasses + 1> next = start;
    for (uint32_t i = 0; i < left_count; ++i) order[next[classes[left[i]]]++] = left[i];
    std::array<uint32_t, kMax> apart; // indices of rays passed to `rest`
    uint32_t apart_count = 0;
    for (uint32_t c = 0; c < kFirstMiss; ++c) {
      const uint32_t end = start[c + 1];
      for (uint32_t k = start[c]; k < end;) {
        const uint32_t size = std::min(end - k, kGroup);
        if (size < kMinPacketRays || packet.is_incoherent()) {
          for (; k < end; ++k) apart[apart_count++] = static_cast<uint32_t>(first) + order[k];
          break;
        }
        const auto number = [&](uint32_t r) {
          return [&order, k, r](uint32_t i) { return order[k + r * kRayLanes + i]; };
        };
        const auto ray_at = [&](uint32_t r) {
          return [part, at = order + k + r * kRayLanes](uint32_t i) -> const Ray& { return part[at[i]]; };
        };
        if (size == kGroup) {
          for (uint32_t r = 0; r < kPacketRegisters; ++r) load(r, kRayLanes, ray_at(r));
          packet.template trace<kPacketRegisters>();
          for (uint32_t r = 0; r < kPacketRegisters; ++r) deliver(r, number(r));
          k += kGroup;
        } else {
          const uint32_t some = std::min(kRayLanes, size);
          load(0, some, ray_at(0));
          packet.template trace<1>();
          deliver(0, number(0));
          k += some;
        }
      }
    }
    if (apart_count != 0) rest(std::span<const uint32_t>(apart.data(), apart_count));
  }
}

} // namespace kindling::accel::kd::KINDLING_SIMD
