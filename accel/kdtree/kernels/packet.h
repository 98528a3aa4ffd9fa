// Packet traversal: nearby rays of similar direction in lockstep, sixteen to a register.
//
// All rays of a packet have the same signs of direction, so that they meet the children of a node
// in the same order, and the same largest axis, so that they shear triangles alike. A node costs
// one test of its eight boxes against bounds of all rays (Boulos, Wald, Shirley, "Geometric and
// Arithmetic Culling Methods for Entire Ray Packets", 2006). The boxes that remain wait on a stack
// until their turn, when many lie beyond hits found meanwhile; then rays are tested one register
// after another, and no further than is needed to know that two of them enter a node. Nothing is
// remembered of single rays on the way down: a leaf tests all against its box.
//
// Four registers, 8 x 8 pixels of camera rays, share the traversal, so that nodes are fetched,
// branches predicted and packets set up once for 64 rays. A register that enters a node alone
// continues by itself, and so do its last one or two rays, as in trace_tree(). Batches in which
// many shadow rays end up alone are faster in a stream, which the rest of the batch then uses: if
// more than one ray in four does, by experiment. Tried without gain for shadow rays, on few scenes
// and repetitions: tracing the first register of a batch alone to detect incoherence earlier (no
// gain overall), and with it a threshold of one in eight (helps where rays scatter, hurts
// elsewhere).
//
// Distances to boxes and triangle tests are those of trace_tree(), operation by operation. A ray
// may be taken through boxes that it would not have entered alone, which changes no hit. Registers
// are sixteen wide on every target.
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
  Packet(const Tree& tree, const HitFilter& filter) : scene_{&tree, filter} {}
  explicit Packet(const HitFilter& filter) : scene_{nullptr, filter} {}
  Packet(const Packet&) = delete;
  Packet& operator=(const Packet&) = delete;

  [[nodiscard]] PacketRays<kAny>& rays(uint32_t i) { return rays_[i]; }
  // Changes what the next rays are traced through.
  void set_scene(const Tree& tree, uint32_t instance, const Ray* first, const Ray* const* world) {
    scene_.tree = &tree;
    scene_.instance = instance;
    scene_.first = first;
    scene_.world = world;
  }

  // Returns true if many of the rays traced since start_batch() have left their packets, so that a
  // stream is faster.
  [[nodiscard]] bool is_incoherent() const { return kAny && lone_ * 4 > traced_; }
  void start_batch() { lone_ = traced_ = 0; }

  // Traces the first kCount registers, whose rays must be of one class, through a tree that is not
  // empty.
  template <uint32_t kCount>
  void trace() {
    traced_ += kCount * kRayLanes;
    known_bounds_ = 0;
    for_each<kCount>([&](auto r) __attribute__((always_inline)) { rays_[r].prepare(); });
    for (uint32_t k = 0; k < 3; ++k) {
      const bool down = rays_[0].points_down(k);
      near_[k] = kWideLanes * k + (down ? kHighFaces : 0);
      far_[k] = kWideLanes * k + (down ? 0 : kHighFaces);
    }
    signs_ = 0;
    for (uint32_t k = 0; k < 3; ++k) signs_ |= (rays_[0].points_down(k) != kAny ? 1U : 0U) << k;
    const Imath::Box3f& box = scene_.tree->clip_bounds;
    const auto face = [&](bool high, uint32_t k) { return (high ? box.max : box.min)[static_cast<int>(k)]; };
    uint32_t active[kCount], registers = 0;
    for_each<kCount>([&](auto r) __attribute__((always_inline)) {
      active[r] = rays_[r].entering([&](uint32_t k) { return face(rays_[0].points_down(k), k); },
                                    [&](uint32_t k) { return face(!rays_[0].points_down(k), k); });
      registers |= (active[r] != 0 ? 1U : 0U) << r;
    });
    const ChildWord root = scene_.tree->root;
    if (registers == 0) return;
    if ((root & kLeafBit) != 0)
      test_leaf<kCount>(rays_, root, active);
    else
      walk<kCount>(rays_, root, registers);
  }

 private:
  static constexpr size_t kHighFaces = offsetof(BoxNode, high) / sizeof(float);

  // Calls f(0) to f(kCount - 1) with constants.
  template <uint32_t kCount, class F>
  [[gnu::always_inline]] static void for_each(const F& f) {
    [&]<uint32_t... kIndex>(std::integer_sequence<uint32_t, kIndex...>) __attribute__((always_inline)) {
      (f(std::integral_constant<uint32_t, kIndex>()), ...);
    }
    (std::make_integer_sequence<uint32_t, kCount>());
  }
  // A child of a node that some rays may enter.
  struct Entry {
    uint32_t node;
    ChildWord child;
    uint16_t lane;
    uint16_t registers; // bit r: rays of register r may enter
    float enter;        // no ray enters before
  };
  using Stack = std::array<Entry, size_t{kMaxWideDepth} * (kWideLanes - 1) + 2>;

  // Returns the mask of the rays of a register that enter a child.
  [[gnu::always_inline]] uint32_t entering(const PacketRays<kAny>& rays, const BoxNode& node, uint32_t lane) const {
    const float* faces = node.low[0].data() + lane;
    return rays.entering(
        [&](uint32_t k) __attribute__((always_inline)) { return faces[near_[k]]; },
        [&](uint32_t k) __attribute__((always_inline)) { return faces[far_[k]]; });
  }
  // Returns the bounds of the rays, computed once for each register that continues alone.
  template <uint32_t kCount>
  [[gnu::always_inline]] const RayBounds& bounds_of(const PacketRays<kAny>* rays) {
    const uint32_t which = kCount == 1 ? static_cast<uint32_t>(rays - rays_) : kPacketRegisters;
    if (((known_bounds_ >> which) & 1U) == 0) {
      bounds_[which] = PacketRays<kAny>::template bounds<kCount>(rays);
      known_bounds_ |= 1U << which;
    }
    return bounds_[which];
  }
  // Returns the end of the farthest ray.
  template <uint32_t kCount>
  [[gnu::always_inline]] static float farthest_end(const PacketRays<kAny>* rays) {
    Lanes16 end = rays[0].ends();
    for_each<kCount>([&](auto r) __attribute__((always_inline)) { end = max(end, rays[r].ends()); });
    return max_lane(end);
  }

  // Traverses the subtree of a node, which rays of the registers of a mask may enter.
  template <uint32_t kCount>
  void walk(PacketRays<kAny>* rays, ChildWord root, uint32_t registers) {
    const RayBounds& bounds = bounds_of<kCount>(rays);
    float end = farthest_end<kCount>(rays);
    Entry* const stack = stack_of<kCount>();
    uint32_t top = push_children(bounds, root, registers, end, stack, 0);
    while (top != 0) {
      const Entry entry = stack[--top];
      if (!(entry.enter <= end * kBeyond)) continue;
      const BoxNode& node = scene_.tree->nodes[entry.node];
      const ChildWord child = entry.child;
      if ((child & kLeafBit) != 0) {
        uint32_t active[kCount];
        for_each<kCount>([&](auto r) __attribute__((always_inline)) {
          active[r] = ((entry.registers >> r) & 1U) != 0 ? entering(rays[r], node, entry.lane) : 0;
        });
        test_leaf<kCount>(rays, child, active);
        end = farthest_end<kCount>(rays);
        if (kAny && end < 0.0f) return;
        continue;
      }
      if constexpr (kCount == 1) {
        const uint32_t active = entering(rays[0], node, entry.lane);
        if (std::popcount(active) > kLoneRays) {
          top = push_children(bounds, child, 1, end, stack, top);
        } else if (active != 0) {
          trace_alone(rays[0], child, active);
          end = farthest_end<1>(rays);
        }
      } else {
        uint32_t left = entry.registers, found = 0;
        for (uint32_t rest = left; rest != 0 && (found & (found - 1)) == 0; rest &= rest - 1) {
          const auto r = static_cast<uint32_t>(std::countr_zero(rest));
          (entering(rays[r], node, entry.lane) != 0 ? found : left) ^= 1U << r;
        }
        if ((found & (found - 1)) != 0) {
          top = push_children(bounds, child, left, end, stack, top);
        } else if (found != 0) {
          walk<1>(rays + std::countr_zero(found), child, 1);
          end = farthest_end<kCount>(rays);
        }
      }
    }
  }

  // Pushes the children of a node that rays within the bounds may enter before the end, nearest on
  // top or, for any hit, farthest: near the surface that shadow rays leave there is little. Returns
  // the new height of the stack.
  [[gnu::always_inline]] uint32_t push_children(const RayBounds& bounds, ChildWord number, uint32_t registers,
                                                float end, Entry* stack, uint32_t top) const {
    const BoxNode& node = scene_.tree->nodes[number];
    const float* faces = node.low[0].data();
    Lanes8 enter(bounds.t_min), leave(end);
    for (uint32_t k = 0; k < 3; ++k) {
      // The bounds of distances hold where these are positive. Elsewhere their sign is right, and
      // that is enough, since rays begin at 0 or later.
      enter = max(enter,
                  (Lanes8::load(faces + near_[k]) - Lanes8(bounds.near_origin[k])) * Lanes8(bounds.near_reciprocal[k]));
      leave =
          min(leave, (Lanes8::load(faces + far_[k]) - Lanes8(bounds.far_origin[k])) * Lanes8(bounds.far_reciprocal[k]));
    }
    alignas(32) std::array<float, kWideLanes> enters;
    const uint32_t order = node.order[signs_];
    enter.store(enters.data());
    const uint32_t entered = at_most(enter, leave * Lanes8(kWiden)); // by lane
    // Branches on purpose: if predicted, the next node does not wait for this test.
    for (int position = kWideLanes - 1; position >= 0; --position) {
      const uint32_t lane = (order >> (4 * position)) & 7U;
      if (((entered >> lane) & 1U) == 0) continue;
      assert(top < std::tuple_size_v<Stack>);
      stack[top++] = {number, node.child[lane], static_cast<uint16_t>(lane), static_cast<uint16_t>(registers),
                      enters[lane]};
    }
    return top;
  }

  // Maximum number of active rays in a register that continue one by one.
  static constexpr int kLoneRays = kAny ? 1 : 2;

  void trace_alone(PacketRays<kAny>& rays, ChildWord child, uint32_t active) {
    for (; active != 0; active &= active - 1) {
      ++lone_;
      rays.trace_alone(scene_, static_cast<uint32_t>(std::countr_zero(active)), child);
    }
  }

  // Tests the active rays of each register against a leaf.
  template <uint32_t kCount>
  [[gnu::always_inline]] void test_leaf(PacketRays<kAny>* rays, ChildWord child, uint32_t (&active)[kCount]) {
    const LeafUnit* unit = scene_.tree->leaves.data() + (child & ~kLeafBit);
    uint32_t all = 0; // rays of registers that are tested together
    for_each<kCount>([&](auto r) __attribute__((always_inline)) {
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
      const uint32_t next = block.units_to_next();
      if (next == 0) break;
      unit += next;
    }
  }

  template <uint32_t kCount>
  Entry* stack_of() {
    if constexpr (kCount == 1)
      return one_stack_.data();
    else
      return stack_.data();
  }

  typename PacketRays<kAny>::Scene scene_;
  std::array<size_t, 3> near_{}, far_{}; // positions of the faces that rays meet first and last, in floats
  uint32_t signs_ = 0;                   // index of the order of children, reversed for any hit
  uint32_t lone_ = 0, traced_ = 0;       // counted since start_batch()
  uint32_t known_bounds_ = 0;            // bit i: bounds_[i] is set
  std::array<RayBounds, kPacketRegisters + 1> bounds_; // of single registers; of all
  PacketRays<kAny> rays_[kPacketRegisters];
  Stack one_stack_, stack_;
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
    for (uint32_t c = 0; c <= kShort; ++c) {
      const uint32_t end = start[c + 1];
      for (uint32_t k = start[c]; k < end;) {
        const uint32_t size = std::min(end - k, kGroup);
        if (size < kMinPacketRays || c == kShort || packet.is_incoherent()) {
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
