// Sixteen rays of a packet: SIMD lanes, best hits, and the leaf test.
//
// In a leaf, triangles that lie to one side of all rays are culled first, all at once, by interval
// arithmetic over the rays; the others are tested one by one against all rays. If only few rays
// have reached a leaf, each is tested against all triangles instead.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/ray_lanes.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// Number of ray classes. A class holds the signs of the direction in bits 0 to 2, and the index of
// its largest axis above. Rays whose directions are short form class kShort, and those that miss by
// definition the last one.
inline constexpr uint32_t kRayClasses = 32, kShort = 24;

// Byte i of an entry is bit i of its index.
inline constexpr std::array<uint64_t, 256> kBitsToBytes = [] {
  std::array<uint64_t, 256> table{};
  for (uint64_t bits = 0; bits < 256; ++bits)
    for (uint64_t i = 0; i < 8; ++i) table[bits] |= ((bits >> i) & 1U) << (8 * i);
  return table;
}();

// The classes of sixteen rays, stored as one mask per bit of the class.
struct RayClasses {
  std::array<uint32_t, 5> bits;
  uint32_t apart; // those of the last two classes

  RayClasses() = default;
  explicit RayClasses(const RayLanes& lanes) {
    const uint32_t misses = ~lanes.can_hit() & kAllRays;
    apart = misses | lanes.is_short();
    for (size_t k = 0; k < 3; ++k) bits[k] = (sign_bits(Lanes16::load(lanes.direction[k])) & ~apart) | misses;
    const RayLanes::LargestAxis largest = lanes.largest_axis();
    bits[3] = largest.y | apart;
    bits[4] = (~(largest.x | largest.y) & kAllRays) | apart;
  }
  // Writes the classes, one byte per ray.
  void store(uint8_t* out) const {
    for (uint32_t half = 0; half < kRayLanes; half += 8) {
      uint64_t bytes = 0;
      for (size_t k = 0; k < bits.size(); ++k) bytes |= kBitsToBytes[(bits[k] >> half) & 0xffU] << k;
      std::memcpy(out + half, &bytes, sizeof(bytes));
    }
  }
};

// Determines whether several groups of sixteen rays are all of one class that packets trace.
class CommonClass {
 public:
  // Adds the first `count` of sixteen rays.
  void add(const RayClasses& classes, uint32_t count = kRayLanes) {
    const uint32_t used = kAllRays >> (kRayLanes - count);
    for (size_t k = 0; k < all_.size(); ++k) {
      all_[k] &= classes.bits[k] | (kAllRays ^ used);
      any_[k] |= classes.bits[k] & used;
    }
    apart_ |= classes.apart & used;
  }
  [[nodiscard]] bool agree() const {
    uint32_t mixed = apart_;
    for (size_t k = 0; k < all_.size(); ++k) mixed |= all_[k] == kAllRays ? 0 : any_[k];
    return mixed == 0;
  }

 private:
  std::array<uint32_t, 5> all_{kAllRays, kAllRays, kAllRays, kAllRays, kAllRays}, any_{};
  uint32_t apart_ = 0;
};

// Bounds of rays of one class: of their distances to the near faces of boxes from below, and to the
// far faces from above, without any margin, since rounding is monotonic.
struct RayBounds {
  std::array<float, 3> near_origin, far_origin;         // the nearest to near faces; the farthest from far ones
  std::array<float, 3> near_reciprocal, far_reciprocal; // of the least and of the largest magnitude
  float t_min;
};

// The tree that a packet is traced through, and the rays that the filter sees.
struct PacketScene {
  const Tree* tree;
  const HitFilter& filter;
  // In the space of an instance: its index, the first ray of an array of rays in its space, and the
  // world's rays by position in this array.
  uint32_t instance = kNoId;
  const Ray* first = nullptr;
  const Ray* const* world = nullptr;

  [[nodiscard]] CandidateFilter filter_of(const Ray& ray) const {
    return {filter, world == nullptr ? ray : *world[&ray - first], *tree, instance};
  }
};

template <bool kAny>
class PacketRays {
 public:
  using Scene = PacketScene;

  // Loads 1 to 16 rays; ray_at(i) refers to ray i. Rays to be traced must be of one class, and not
  // one of misses.
  template <class RayAt>
  void load(uint32_t count, const RayAt& ray_at) {
    lanes_.load(count, ray_at);
    for (uint32_t i = 0; i < count; ++i) ray_[i] = &ray_at(i);
    for (uint32_t i = count; i < kRayLanes; ++i) lanes_.t_max[i] = -1.0f; // an empty interval
    hit_ = 0;
  }
  [[nodiscard]] RayClasses classes() const { return RayClasses(lanes_); }
  // Calls finish(i, hit) for each ray with a hit.
  template <class Finish>
  void deliver(const Finish& finish) const {
    alignas(64) float u[kRayLanes], v[kRayLanes];
    if (!kAny && hit_ != 0) {
      (Lanes16::load(e1_) / Lanes16::load(det_)).store(u);
      (Lanes16::load(e2_) / Lanes16::load(det_)).store(v);
    }
    for (uint32_t rest = hit_; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(rest));
      finish(i, kAny ? TreeHit() : TreeHit{lanes_.t_max[i], u[i], v[i], std::bit_cast<uint32_t>(primitive_[i])});
    }
  }

  [[nodiscard]] bool points_down(uint32_t axis) const { return std::signbit(lanes_.direction[axis][0]); }

  // Computes reciprocals and RayShear for all rays, and the ranges of all but reciprocals.
  void prepare() {
    std::array<float, 3> low, high; // of the origins
    for (uint32_t k = 0; k < 3; ++k) {
      const Lanes16 origin = Lanes16::load(lanes_.origin[k]);
      low[k] = min_lane(origin);
      high[k] = max_lane(origin);
      finite_reciprocal(Lanes16::load(lanes_.direction[k])).store(reciprocal_[k]);
    }
    const RayShear first(ray_[0]->origin, ray_[0]->direction);
    kx_ = static_cast<uint32_t>(first.kx);
    ky_ = static_cast<uint32_t>(first.ky);
    kz_ = static_cast<uint32_t>(first.kz);
    const Lanes16 dz = Lanes16::load(lanes_.direction[kz_]);
    const Lanes16 sx = Lanes16::load(lanes_.direction[kx_]) / dz, sy = Lanes16::load(lanes_.direction[ky_]) / dz;
    sx.store(sx_);
    sy.store(sy_);
    (Lanes16(1.0f) / dz).store(sz_);
    x_range_ = {low[kx_], high[kx_], min_lane(sx), max_lane(sx)};
    y_range_ = {low[ky_], high[ky_], min_lane(sy), max_lane(sy)};
    z_low_ = low[kz_];
    z_high_ = high[kz_];
  }
  // Returns the bounds of kCount prepared registers of one class.
  template <uint32_t kCount>
  [[nodiscard, gnu::always_inline]] static RayBounds bounds(const PacketRays* rays) {
    RayBounds out;
    Lanes16 t_min = Lanes16::load(rays[0].lanes_.t_min);
    for (uint32_t r = 1; r < kCount; ++r) t_min = min(t_min, Lanes16::load(rays[r].lanes_.t_min));
    out.t_min = min_lane(t_min);
    for (uint32_t k = 0; k < 3; ++k) {
      Lanes16 low = Lanes16::load(rays[0].lanes_.origin[k]), high = low;
      Lanes16 lowest = Lanes16::load(rays[0].reciprocal_[k]), highest = lowest;
      for (uint32_t r = 1; r < kCount; ++r) {
        const Lanes16 origin = Lanes16::load(rays[r].lanes_.origin[k]),
                      reciprocal = Lanes16::load(rays[r].reciprocal_[k]);
        low = min(low, origin);
        high = max(high, origin);
        lowest = min(lowest, reciprocal);
        highest = max(highest, reciprocal);
      }
      const bool down = rays[0].points_down(k);
      out.near_origin[k] = down ? min_lane(low) : max_lane(high);
      out.far_origin[k] = down ? max_lane(high) : min_lane(low);
      out.near_reciprocal[k] = down ? max_lane(highest) : min_lane(lowest);
      out.far_reciprocal[k] = down ? min_lane(lowest) : max_lane(highest);
    }
    return out;
  }

  // Returns a mask of the rays that enter a box before their ends; near(k) and far(k) are its faces
  // across axis k that rays of this class meet first and last.
  template <class Near, class Far>
  [[nodiscard, gnu::always_inline]] uint32_t entering(const Near& near, const Far& far) const {
    Lanes16 enter = Lanes16::load(lanes_.t_min), leave = Lanes16::load(lanes_.t_max);
    for (uint32_t k = 0; k < 3; ++k) {
      const Lanes16 origin = Lanes16::load(lanes_.origin[k]), reciprocal = Lanes16::load(reciprocal_[k]);
      enter = max((Lanes16(near(k)) - origin) * reciprocal, enter);
      leave = min((Lanes16(far(k)) - origin) * reciprocal, leave);
    }
    return at_most(enter, leave * Lanes16(kWiden));
  }
  // Returns the ends of the rays; negative for any-hit rays that are blocked.
  [[nodiscard]] Lanes16 ends() const { return Lanes16::load(lanes_.t_max); }

  // Traces ray i alone through the subtree of a child.
  [[gnu::noinline]] void trace_alone(const Scene& scene, uint32_t i, ChildWord child) {
    const Ray& ray = *ray_[i];
    const CandidateFilter filter = scene.filter_of(ray);
    const RayShear shear = shear_of_ray(i);
    const WalkingRay walking =
        walking_ray(ray, Float4{reciprocal_[0][i], reciprocal_[1][i], reciprocal_[2][i], 0.0f}, shear, lanes_.t_min[i]);
    float t_far = lanes_.t_max[i];
    TreeHit best = !kAny && ((hit_ >> i) & 1U) != 0 ? hit(i) : TreeHit();
    const TreeHit before = best;
    const bool any = walk_boxes<kAny>(
        *scene.tree, Static(), walking, child, t_far, [&](const LeafUnit* unit) __attribute__((always_inline)) {
          return intersect_leaf<kAny>(unit, Static(), shear, walking.t_min, filter, t_far, best);
        });
    if (any || best.t != before.t || best.primitive != before.primitive) put(i, any ? -1.0f : best.t, best);
  }

  // With fewer active rays in a leaf than this, rays are tested one by one.
  static constexpr int kMinLeafRays = 4;

  // Tests the active rays one by one against all blocks of a leaf.
  void test_leaf(const Scene& scene, const LeafUnit* unit, uint32_t active) {
    for (uint32_t rest = active; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(rest));
      const CandidateFilter filter = scene.filter_of(*ray_[i]);
      TreeHit best = !kAny && ((hit_ >> i) & 1U) != 0 ? hit(i) : TreeHit();
      const uint32_t before = best.primitive;
      const bool any =
          intersect_leaf<kAny>(unit, Static(), shear_of_ray(i), lanes_.t_min[i], filter, lanes_.t_max[i], best);
      if (best.primitive != before) put(i, any ? -1.0f : best.t, best);
    }
  }

  // Returns a mask of the triangles that do not lie to one side of all rays.
  [[nodiscard]] uint32_t possible(const LeafBlock& block) const {
    const Lanes16 z = Lanes16::load(block.row(kz_)), z_low = z - Lanes16(z_high_), z_high = z - Lanes16(z_low_);
    const Sides x = sides_of(block.row(kx_), x_range_, z_low, z_high),
                y = sides_of(block.row(ky_), y_range_, z_low, z_high);
    uint32_t out = 0;
    for_each_group(block, [&](uint32_t first, uint32_t count) {
      const WideIntLanes a = WideIntLanes::load(block.corners() + first);
      const WideIntLanes corners = bits_of(a, shift_right<4>(a), shift_right<8>(a));
      const uint32_t missed = subset_of(corners, x.above) | subset_of(corners, x.below) | subset_of(corners, y.above) |
                              subset_of(corners, y.below);
      out |= (~missed & ((1U << count) - 1U)) << first;
      return false;
    });
    return out;
  }

  // Tests some triangles of a block, given as a mask, against all rays.
  void test_block(const Scene& scene, const LeafBlock& block, uint32_t triangles, uint32_t active) {
    const Lanes16 ox = Lanes16::load(lanes_.origin[kx_]), oy = Lanes16::load(lanes_.origin[ky_]),
                  oz = Lanes16::load(lanes_.origin[kz_]), sx = Lanes16::load(sx_), sy = Lanes16::load(sy_), zero(0.0f);
    const float *px = block.row(kx_), *py = block.row(ky_), *pz = block.row(kz_);
    const uint16_t* corners = block.corners();
    const auto shear = [&](uint32_t vertex, Lanes16& x, Lanes16& y, Lanes16& z) {
      z = Lanes16(pz[vertex]) - oz;
      x = (Lanes16(px[vertex]) - ox) - sx * z;
      y = (Lanes16(py[vertex]) - oy) - sy * z;
    };
    for (; triangles != 0; triangles &= triangles - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(triangles));
      Lanes16 ax, ay, az, bx, by, bz, cx, cy, cz;
      shear(corners[i] & 15U, ax, ay, az);
      shear((corners[i] >> 4) & 15U, bx, by, bz);
      shear((corners[i] >> 8) & 15U, cx, cy, cz);
      const Lanes16 e0 = difference_of_products(cx, by, cy, bx), e1 = difference_of_products(ax, cy, ay, cx),
                    e2 = difference_of_products(bx, ay, by, ax);
      const uint32_t inside = (at_least(min(min(e0, e1), e2), zero) | at_most(max(max(e0, e1), e2), zero)) & active;
      if (inside == 0) continue;
      const Lanes16 det = (e0 + e1) + e2;
      const Lanes16 t = (((e0 * az + e1 * bz) + e2 * cz) * Lanes16::load(sz_)) / det;
      const uint32_t mask =
          inside & differs(det, zero) & above(t, Lanes16::load(lanes_.t_min)) & at_most(t, Lanes16::load(lanes_.t_max));
      if (mask != 0) take(scene, block, i, mask, t, e1, e2, det);
    }
  }

 private:
  [[nodiscard]] RayShear shear_of_ray(uint32_t i) const {
    RayShear shear;
    shear.kx = static_cast<int>(kx_);
    shear.ky = static_cast<int>(ky_);
    shear.kz = static_cast<int>(kz_);
    shear.sx = sx_[i];
    shear.sy = sy_[i];
    shear.sz = sz_[i];
    shear.origin = {lanes_.origin[kx_][i], lanes_.origin[ky_][i], lanes_.origin[kz_][i]};
    return shear;
  }

  // Ranges over the packet of one coordinate of the origin and of the shear.
  struct Range {
    float origin_low, origin_high, shear_low, shear_high;
  };
  // Masks of vertices whose sheared coordinate is above or below zero for all rays. Rounding is
  // monotonic, so these bound what the rays themselves would compute, without any margin.
  struct Sides {
    uint32_t above, below;
  };
  static Sides sides_of(const float* row, const Range& range, const Lanes16& z_low, const Lanes16& z_high) {
    const Lanes16 p = Lanes16::load(row), low(range.shear_low), high(range.shear_high), zero(0.0f);
    const Lanes16 a = low * z_low, b = low * z_high, c = high * z_low, d = high * z_high;
    const Lanes16 low_bound = (p - Lanes16(range.origin_high)) - max(max(a, b), max(c, d));
    const Lanes16 high_bound = (p - Lanes16(range.origin_low)) - min(min(a, b), min(c, d));
    return {kd::KINDLING_SIMD::above(low_bound, zero), kd::KINDLING_SIMD::above(zero, high_bound)};
  }

  // Records a triangle that the rays of the mask hit.
  void take(const Scene& scene, const LeafBlock& block, uint32_t triangle, uint32_t mask, const Lanes16& t,
            const Lanes16& e1, const Lanes16& e2, const Lanes16& det) {
    const uint32_t primitive = block.primitive(triangle);
    // Ties go to the smallest primitive; most ties are the same one, met again in another leaf.
    const uint32_t ties = kAny ? 0 : mask & hit_ & at_least(t, Lanes16::load(lanes_.t_max));
    if (ties != 0) mask &= ~ties | numbers_above(primitive_, primitive);
    if (mask == 0) return;
    if (((block.filtered() >> triangle) & 1U) != 0) [[unlikely]]
      mask = accepted(scene, primitive, mask, t, e1 / det, e2 / det);
    const auto keep = [&](float* lanes, const Lanes16& x) { select(mask, Lanes16::load(lanes), x).store(lanes); };
    keep(lanes_.t_max, kAny ? Lanes16(-1.0f) : t);
    hit_ |= mask;
    if (kAny) return;
    keep(e1_, e1);
    keep(e2_, e2);
    keep(det_, det);
    keep(primitive_, Lanes16(std::bit_cast<float>(primitive)));
  }
  // Returns the rays of the mask for which the filter accepts the hit.
  uint32_t accepted(const Scene& scene, uint32_t primitive, uint32_t mask, const Lanes16& t, const Lanes16& u,
                    const Lanes16& v) const {
    alignas(64) float ts[kRayLanes], us[kRayLanes], vs[kRayLanes];
    t.store(ts);
    u.store(us);
    v.store(vs);
    for (uint32_t rest = mask; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(rest));
      const CandidateFilter filter = scene.filter_of(*ray_[i]);
      if (!filter.accepts({ts[i], us[i], vs[i], primitive})) mask &= ~(1U << i);
    }
    return mask;
  }
  // Returns the nearest hit of ray i so far.
  [[nodiscard]] TreeHit hit(uint32_t i) const {
    return {lanes_.t_max[i], e1_[i] / det_[i], e2_[i] / det_[i], std::bit_cast<uint32_t>(primitive_[i])};
  }
  void put(uint32_t i, float t_far, const TreeHit& hit) {
    lanes_.t_max[i] = t_far;
    e1_[i] = hit.u;
    e2_[i] = hit.v;
    det_[i] = 1.0f;
    primitive_[i] = std::bit_cast<float>(hit.primitive);
    hit_ |= 1U << i;
  }

  uint32_t kx_ = 0, ky_ = 0, kz_ = 0;  // axes of the sheared space
  Range x_range_{}, y_range_{};        // in the sheared space
  float z_low_ = 0.0f, z_high_ = 0.0f; // range of the origins
  RayLanes lanes_;                     // t_max is narrowed by hits; -1 for blocked any-hit rays
  alignas(64) float reciprocal_[3][kRayLanes], sx_[kRayLanes], sy_[kRayLanes], sz_[kRayLanes];
  // Best hits, at distance t_max: u is e1 / det, v is e2 / det; primitive indices are stored as
  // bits.
  alignas(64) float e1_[kRayLanes], e2_[kRayLanes], det_[kRayLanes], primitive_[kRayLanes];
  uint32_t hit_ = 0; // bit i: ray i has a hit
  const Ray* ray_[kRayLanes];
};

} // namespace kindling::accel::kd::KINDLING_SIMD
