// Packets through instances.
//
// Up to 64 rays whose directions have the same signs go down the hierarchy of instances together,
// as a packet goes down a tree. Those that enter the box of an instance are taken into its space,
// and form a packet there if their directions, turned with the instance, still are of one class.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/instance_stream.h"
#include "accel/kdtree/kernels/instances.h"
#include "accel/kdtree/kernels/level_rays.h"
#include "accel/kdtree/kernels/packet.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// `Instances` and `Calls` are those of InstanceStream; Instances also has enter_all(), which takes
// the rays of a mask into the space of an instance.
template <bool kAny, class Instances, class Calls>
class InstancePacket {
 public:
  static constexpr uint32_t kRays = kPacketRegisters * kRayLanes;

  // `rays`: of the whole batch, as numbered by the calls.
  InstancePacket(const Instances& instances, const HitFilter& filter, std::span<const Ray> rays, const Calls& calls)
      : instances_(instances), level_(instances.level()), filter_(filter), all_(rays), calls_(calls), packet_(filter) {}

  // Traces ray `first` and up to kRays - 1 rays behind it, or returns false: a stream is faster.
  bool trace(size_t first) {
    const auto group = all_.subspan(first, std::min<size_t>(kRays, all_.size() - first));
    if (group.size() < kFewest || !have_the_same_signs(group) || is_incoherent()) return false;
    CommonClass common;
    for (uint32_t r = 0; r < kPacketRegisters; ++r) {
      rays_[r].load(
          [&](uint32_t i) -> const Ray& { return group[std::min<size_t>(r * kRayLanes + i, group.size() - 1)]; });
      common.add(rays_[r].classes());
    }
    if (!common.agree()) return false;
    for (uint32_t r = 0; r < kPacketRegisters; ++r)
      rays_[r].prepare(level_.growth(), [&](uint32_t i) {
        const size_t number = r * kRayLanes + i;
        return number < group.size() ? calls_.end_of(first + number) : -1.0f;
      });
    constexpr size_t kHigh = offsetof(InstanceNode, high) / sizeof(float);
    signs_ = 0;
    for (uint32_t k = 0; k < 3; ++k) {
      const bool down = rays_[0].points_down(k);
      first_[k] = 8 * k + (down ? kHigh : 0);
      last_[k] = 8 * k + (down ? 0 : kHigh);
      signs_ |= static_cast<uint32_t>(down) << k;
    }
    set_bounds();
    walk();
    return !is_incoherent();
  }

 private:
  static constexpr size_t kFewest = 16;   // rays of a packet
  static constexpr uint32_t kMinRays = 4; // fewer enter an instance one by one
  static constexpr int kLoneRays = 2;     // that continue one by one in the hierarchy
  static constexpr size_t kFewTogether = 12;
  struct Entry {
    uint32_t node, child, lane;
    float enter; // no ray enters before
  };

  // Shadow rays of which few enter an instance together are faster in a stream, even those that a
  // packet has already taken some way.
  [[nodiscard]] bool is_incoherent() const { return kAny && entries_ >= 4 && entered_ < kFewTogether * entries_; }

  static bool have_the_same_signs(std::span<const Ray> rays) {
    Int4 all = std::bit_cast<Int4>(load_direction(rays[0])), any = all;
    for (const Ray& ray : rays) {
      const Int4 bits = std::bit_cast<Int4>(load_direction(ray));
      all &= bits;
      any |= bits;
    }
    const Int4 differ = all ^ any;
    return differ[0] >= 0 && differ[1] >= 0 && differ[2] >= 0;
  }

  template <class Of>
  static float min_of(const LevelRays (&rays)[kPacketRegisters], const Of& of) {
    Lanes16 out = Lanes16::load(of(rays[0]));
    for (uint32_t r = 1; r < kPacketRegisters; ++r) out = min(out, Lanes16::load(of(rays[r])));
    return min_lane(out);
  }
  template <class Of>
  static float max_of(const LevelRays (&rays)[kPacketRegisters], const Of& of) {
    Lanes16 out = Lanes16::load(of(rays[0]));
    for (uint32_t r = 1; r < kPacketRegisters; ++r) out = max(out, Lanes16::load(of(rays[r])));
    return max_lane(out);
  }
  void set_bounds() {
    bounds_.t_min = min_of(rays_, [](const LevelRays& rays) { return rays.begin; });
    for (uint32_t k = 0; k < 3; ++k) {
      const bool down = rays_[0].points_down(k);
      const auto near = [k](const LevelRays& rays) { return rays.near[k]; };
      const auto far = [k](const LevelRays& rays) { return rays.far[k]; };
      const auto reciprocal = [k](const LevelRays& rays) { return rays.reciprocal[k]; };
      bounds_.near_origin[k] = down ? min_of(rays_, near) : max_of(rays_, near);
      bounds_.far_origin[k] = down ? max_of(rays_, far) : min_of(rays_, far);
      bounds_.near_reciprocal[k] = down ? max_of(rays_, reciprocal) : min_of(rays_, reciprocal);
      bounds_.far_reciprocal[k] = down ? min_of(rays_, reciprocal) : max_of(rays_, reciprocal);
    }
  }
  [[nodiscard]] float farthest_end() const {
    return max_of(rays_, [](const LevelRays& rays) { return rays.lanes.t_max; });
  }

  void walk() {
    float end = farthest_end();
    uint32_t top = push_children(0, end, 0);
    while (top != 0) {
      const Entry entry = stack_[--top];
      if (!(entry.enter <= end * kBeyond)) continue;
      const float* faces = &level_.node(entry.node).low[0][0] + entry.lane;
      std::array<uint32_t, kPacketRegisters> active;
      int count = 0;
      for (uint32_t r = 0; r < kPacketRegisters; ++r) {
        active[r] = rays_[r].entering(
            [&](uint32_t k) __attribute__((always_inline)) { return faces[first_[k]]; },
            [&](uint32_t k) __attribute__((always_inline)) { return faces[last_[k]]; });
        count += std::popcount(active[r]);
      }
      if (count == 0) continue;
      if ((entry.child & InstanceNode::kBoxBit) != 0) {
        enter(entry.child & ~InstanceNode::kBoxBit, active, static_cast<uint32_t>(count));
      } else if (count > kLoneRays) {
        top = push_children(entry.child, end, top);
        continue;
      } else {
        for_each(active, [&](uint32_t place) {
          ++entries_;
          ++entered_;
          trace_alone(place, [&](size_t number, float& t_far) { calls_.visit(number, entry.child, t_far); });
        });
      }
      if (filter_.abandoned() || is_incoherent()) return;
      end = farthest_end();
    }
  }

  // Pushes the children of a node that rays within the bounds may enter before the end, nearest on
  // top. Returns the new height of the stack.
  uint32_t push_children(uint32_t number, float end, uint32_t top) {
    const InstanceNode& node = level_.node(number);
    const float* faces = &node.low[0][0];
    Lanes8 enter(bounds_.t_min), leave(end * kWiden);
    for (uint32_t k = 0; k < 3; ++k) {
      enter = max(enter, (Lanes8::load(faces + first_[k]) - Lanes8(bounds_.near_origin[k])) *
                             Lanes8(bounds_.near_reciprocal[k]));
      leave = min(leave,
                  (Lanes8::load(faces + last_[k]) - Lanes8(bounds_.far_origin[k])) * Lanes8(bounds_.far_reciprocal[k]));
    }
    alignas(32) std::array<float, 8> enters;
    enter.store(enters.data());
    const uint32_t entered = at_most(enter, leave * Lanes8(kWiden)), order = node.order[signs_];
    for (int position = 7; position >= 0; --position) {
      const uint32_t lane = (order >> (4 * position)) & 7U;
      if (((entered >> lane) & 1U) == 0) continue;
      assert(top < stack_.size());
      const uint32_t child = node.child[lane];
      if ((child & InstanceNode::kBoxBit) != 0) instances_.fetch(child & ~InstanceNode::kBoxBit);
      stack_[top++] = {number, child, lane, enters[lane]};
    }
    return top;
  }

  // Rays are numbered by register and lane. Calls f(ray) for those of the masks.
  template <class F>
  static void for_each(const std::array<uint32_t, kPacketRegisters>& masks, const F& f) {
    for (uint32_t r = 0; r < kPacketRegisters; ++r)
      for (uint32_t rest = masks[r]; rest != 0; rest &= rest - 1)
        f(r * kRayLanes + static_cast<uint32_t>(std::countr_zero(rest)));
  }
  [[nodiscard]] const Ray& ray(uint32_t place) const { return *rays_[place / kRayLanes].ray[place % kRayLanes]; }
  [[nodiscard]] size_t number_of(uint32_t place) const { return static_cast<size_t>(&ray(place) - all_.data()); }
  [[nodiscard]] float& end_of(uint32_t place) { return rays_[place / kRayLanes].lanes.t_max[place % kRayLanes]; }
  template <class Trace>
  void trace_alone(uint32_t place, const Trace& trace) {
    float t_far = end_of(place);
    trace(number_of(place), t_far);
    end_of(place) = t_far;
  }

  // Takes `count` rays, those of the masks, through an instance.
  void enter(uint32_t number, const std::array<uint32_t, kPacketRegisters>& active, uint32_t count) {
    const auto trace_one = [&](uint32_t place) {
      trace_alone(place, [&](size_t i, float& t_far) { calls_.trace_in(i, number, t_far); });
    };
    ++entries_;
    entered_ += count;
    if (count < kMinRays) return for_each(active, trace_one);
    std::array<Ray, kRays> inside;
    std::array<const Ray*, kRays> world;
    std::array<uint32_t, kPacketRegisters> entered{};
    Entered in;
    for (uint32_t r = 0; r < kPacketRegisters; ++r)
      if (active[r] != 0)
        entered[r] = instances_.enter_all(number, rays_[r], active[r], &inside[size_t{r} * kRayLanes], in);
    std::array<uint8_t, kRays> places;
    count = 0;
    for_each(entered, [&](uint32_t place) {
      world[place] = &ray(place);
      places[count++] = static_cast<uint8_t>(place);
    });
    if (in.is_apart || count < kMinRays) return for_each(entered, trace_one);
    packet_.set_scene(*in.tree, in.instance, inside.data(), world.data());
    const uint32_t registers = (count + kRayLanes - 1) / kRayLanes;
    CommonClass common;
    for (uint32_t r = 0; r < registers; ++r) {
      const uint32_t size = std::min(kRayLanes, count - r * kRayLanes);
      packet_.rays(r).load(size, [&](uint32_t i) -> const Ray& { return inside[places[r * kRayLanes + i]]; });
      common.add(packet_.rays(r).classes(), size);
    }
    if (!common.agree()) return for_each(entered, trace_one);
    trace_packet(registers);
    for (uint32_t r = 0; r < registers; ++r)
      packet_.rays(r).deliver([&](uint32_t i, const TreeHit& hit) {
        const uint32_t place = places[r * kRayLanes + i];
        calls_.merge(number_of(place), *in.tree, in.instance, hit);
        end_of(place) = kAny ? -1.0f : hit.t;
      });
  }
  void trace_packet(uint32_t registers) {
    if (registers == 1)
      packet_.template trace<1>();
    else if (registers == 2)
      packet_.template trace<2>();
    else if (registers == 3)
      packet_.template trace<3>();
    else
      packet_.template trace<4>();
  }

  const Instances instances_;
  const InstanceLevel& level_;
  const HitFilter& filter_;
  std::span<const Ray> all_;
  const Calls& calls_;
  std::array<size_t, 3> first_{}, last_{}; // positions of the faces that rays meet first and last, in floats
  uint32_t signs_ = 0;
  size_t entries_ = 0, entered_ = 0; // into instances so far, and rays in them
  RayBounds bounds_;
  LevelRays rays_[kPacketRegisters];
  std::array<Entry, InstanceLevel::kStackSize> stack_;
  Packet<kAny> packet_;
};

// Traces a coherent batch through instances, after the world's tree: groups of 64 rays in packets
// where that is faster, the others as a stream. `Queries` as for BatchAnswers.
template <bool kAny, class Queries, class Instances, class Answer>
[[gnu::noinline]] void trace_coherent_instances(const Structure& s, const Instances& instances,
                                                std::span<const Ray> all, std::span<Answer> answers) {
  using Calls = BatchAnswers<kAny, Queries, Answer>;
  using Packets = InstancePacket<kAny, Instances, Calls>;
  struct LeftCalls : Calls {
    uint32_t done = 0; // bit i: group i has been traced
    [[nodiscard]] float end_of(size_t i) const {
      return ((done >> (i / Packets::kRays)) & 1U) == 0 ? Calls::end_of(i) : -1.0f;
    }
  };
  constexpr size_t kPart = 4 * size_t{Packets::kRays};
  for (size_t first = 0; first < all.size(); first += kPart) {
    const auto rays = all.subspan(first, std::min(kPart, all.size() - first));
    LeftCalls calls{{{s, rays}, answers.subspan(first, rays.size())}};
    Packets packets(instances, s.filter, rays, calls);
    bool left = false;
    for (size_t i = 0; i < rays.size() && !s.filter.abandoned(); i += Packets::kRays) {
      const bool traced = packets.trace(i);
      left = left || !traced;
      calls.done |= static_cast<uint32_t>(traced) << (i / Packets::kRays);
    }
    if (!left) continue;
    if (rays.size() >= kMinStreamRays && instances.level().depth() <= TreesInTurn::kMaxDepth) {
      InstanceStream<kAny, Instances> stream(instances, s.filter, nullptr);
      stream.trace(rays, calls);
      continue;
    }
    for (size_t i = 0; i < rays.size(); ++i) {
      float t_far = calls.end_of(i);
      if (t_far >= 0.0f && can_hit(rays[i])) calls.visit(i, 0, t_far);
    }
  }
}

} // namespace kindling::accel::kd::KINDLING_SIMD
