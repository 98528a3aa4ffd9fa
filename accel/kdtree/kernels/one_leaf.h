// Batches of rays through a tree that is one leaf: lanes of rays, one triangle after the other.
//
// Without nodes, all rays meet all triangles, so lanes are better filled with rays than with
// triangles: no corner has to be picked from its vertices. Rays are sorted by the largest axis of
// their directions, so that those in a register share the axes of their sheared space.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/ray_lanes.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

[[nodiscard]] inline bool is_one_leaf(const Tree& tree) {
  return tree.root != kEmptyChild && (tree.root & kLeafBit) != 0;
}

// Returns kx, ky and kz of RayShear for directions with this largest axis.
[[nodiscard]] inline std::array<uint32_t, 3> sheared_axes(uint32_t axis) {
  return {(axis + 1) % 3, (axis + 2) % 3, axis};
}

// Up to kMax rays, sorted by the largest axis of their directions. Each axis begins with a full
// register; places that have no ray have an empty interval.
class RaysByAxis {
 public:
  static constexpr uint32_t kMax = 128;

  // Takes 1 to kMax rays. Calls apart(i) for those that it leaves out because their direction
  // is_short().
  template <class Apart>
  void sort(std::span<const Ray> rays, const Apart& apart) {
    std::array<RayLanes, kMax / kRayLanes> loaded;
    std::array<std::array<uint32_t, 3>, kMax / kRayLanes> of_axis; // masks
    const auto registers = static_cast<uint32_t>((rays.size() + kRayLanes - 1) / kRayLanes);
    for (uint32_t r = 0; r < registers; ++r) {
      const auto from = rays.subspan(size_t{r} * kRayLanes);
      const uint32_t count = std::min(kRayLanes, static_cast<uint32_t>(from.size()));
      RayLanes& lanes = loaded[r];
      lanes.load(count, [from](uint32_t i) -> const Ray& { return from[i]; });
      const uint32_t valid = lanes.can_hit() & (kAllRays >> (kRayLanes - count)), is_short = valid & lanes.is_short();
      const RayLanes::LargestAxis largest = lanes.largest_axis();
      const uint32_t sorted = valid & ~is_short;
      of_axis[r] = {largest.x & sorted, largest.y & sorted, sorted & ~(largest.x | largest.y)};
      for (uint32_t rest = is_short; rest != 0; rest &= rest - 1)
        apart(r * kRayLanes + static_cast<uint32_t>(std::countr_zero(rest)));
    }
    uint32_t at = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      begin_[axis] = at;
      const std::array<uint32_t, 3> k = sheared_axes(axis);
      for (uint32_t r = 0; r < registers; ++r) {
        for (uint32_t rest = of_axis[r][axis]; rest != 0; rest &= rest - 1, ++at) {
          const auto i = static_cast<uint32_t>(std::countr_zero(rest));
          const RayLanes& lanes = loaded[r];
          for (size_t j = 0; j < 3; ++j) {
            origin[j][at] = lanes.origin[k[j]][i];
            direction[j][at] = lanes.direction[k[j]][i];
          }
          t_min[at] = lanes.t_min[i];
          t_max[at] = lanes.t_max[i];
          number[at] = static_cast<uint8_t>(r * kRayLanes + i);
        }
      }
      for (; at % kLanes != 0; ++at) { // copies of a ray, which hit nothing
        for (size_t j = 0; j < 3; ++j) {
          origin[j][at] = origin[j][at - 1];
          direction[j][at] = direction[j][at - 1];
        }
        t_min[at] = 0.0f;
        t_max[at] = -1.0f;
      }
    }
    begin_[3] = at;
  }

  [[nodiscard]] uint32_t begin(uint32_t axis) const { return begin_[axis]; }
  [[nodiscard]] uint32_t end(uint32_t axis) const { return begin_[axis + 1]; }

  // By place. The axes of coordinates are those of the sheared space.
  static constexpr uint32_t kPlaces = kMax + 3 * kLanes;
  alignas(64) float origin[3][kPlaces], direction[3][kPlaces], t_min[kPlaces], t_max[kPlaces];
  uint8_t number[kPlaces]; // of the ray

 private:
  std::array<uint32_t, 4> begin_;
};

// The rays of a register while they are tested. The arithmetic is that of accel/triangle.h,
// operation by operation.
template <bool kAny>
class LeafRays {
 public:
  LeafRays(const RaysByAxis& rays, uint32_t first, uint32_t axis)
      : axes_(sheared_axes(axis)), ox_(WideLanes::load(&rays.origin[0][first])),
        oy_(WideLanes::load(&rays.origin[1][first])), oz_(WideLanes::load(&rays.origin[2][first])),
        t_min_(WideLanes::load(&rays.t_min[first])), t_max_(WideLanes::load(&rays.t_max[first])) {
    const WideLanes dz = WideLanes::load(&rays.direction[2][first]);
    sx_ = WideLanes::load(&rays.direction[0][first]) / dz;
    sy_ = WideLanes::load(&rays.direction[1][first]) / dz;
    sz_ = WideLanes(1.0f) / dz;
  }

  // Tests all blocks of a leaf until the trace is abandoned; any hit: until all rays have one.
  // accepts(lane, candidate) is the hit filter's decision.
  template <class Accepts>
  [[gnu::always_inline]] void test(const LeafUnit* unit, const HitFilter& filter, const Accepts& accepts) {
    while (true) {
      const LeafBlock block(unit);
      for (uint32_t i = 0; i < block.triangle_count(); ++i) test(block, i, accepts);
      const uint32_t next = block.units_to_next();
      if (next == 0 || (kAny && at_most(t_min_, t_max_) == 0) || filter.abandoned()) return;
      unit += next;
    }
  }

  // Calls finish(lane, hit) for each ray with a hit.
  template <class Finish>
  void deliver(const Finish& finish) const {
    alignas(64) float t[kLanes], u[kLanes], v[kLanes];
    if (!kAny && hit_ != 0) {
      t_max_.store(t);
      (e1_ / det_).store(u);
      (e2_ / det_).store(v);
    }
    for (uint32_t rest = hit_; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(rest));
      finish(i, kAny ? TreeHit() : TreeHit{t[i], u[i], v[i], primitive_[i]});
    }
  }

 private:
  template <class Accepts>
  [[gnu::always_inline]] void test(const LeafBlock& block, uint32_t triangle, const Accepts& accepts) {
    const uint32_t corners = block.corners()[triangle];
    WideLanes ax, ay, az, bx, by, bz, cx, cy, cz;
    shear(block, corners & 15U, ax, ay, az);
    shear(block, (corners >> 4) & 15U, bx, by, bz);
    shear(block, (corners >> 8) & 15U, cx, cy, cz);
    const WideLanes e0 = difference_of_products(cx, by, cy, bx), e1 = difference_of_products(ax, cy, ay, cx),
                    e2 = difference_of_products(bx, ay, by, ax), zero(0.0f);
    const uint32_t inside = at_least(min(min(e0, e1), e2), zero) | at_most(max(max(e0, e1), e2), zero);
    if (inside == 0) return;
    const WideLanes det = (e0 + e1) + e2;
    const WideLanes t = (((e0 * az + e1 * bz) + e2 * cz) * sz_) / det;
    const uint32_t mask = inside & differs(det, zero) & above(t, t_min_) & at_most(t, t_max_);
    if (mask != 0) take(block, triangle, mask, t, e1, e2, det, accepts);
  }

  [[gnu::always_inline]] void shear(const LeafBlock& block, uint32_t vertex, WideLanes& x, WideLanes& y,
                                    WideLanes& z) const {
    z = WideLanes(block.row(axes_[2])[vertex]) - oz_;
    x = (WideLanes(block.row(axes_[0])[vertex]) - ox_) - sx_ * z;
    y = (WideLanes(block.row(axes_[1])[vertex]) - oy_) - sy_ * z;
  }

  template <class Accepts>
  void take(const LeafBlock& block, uint32_t triangle, uint32_t mask, const WideLanes& t, const WideLanes& e1,
            const WideLanes& e2, const WideLanes& det, const Accepts& accepts) {
    const uint32_t primitive = block.primitive(triangle);
    // Ties go to the smallest primitive.
    for (uint32_t ties = kAny ? 0 : mask & hit_ & at_least(t, t_max_); ties != 0; ties &= ties - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(ties));
      if (primitive >= primitive_[i]) mask &= ~(1U << i);
    }
    if (((block.filtered() >> triangle) & 1U) != 0) [[unlikely]] {
      alignas(64) float ts[kLanes], us[kLanes], vs[kLanes];
      t.store(ts);
      (e1 / det).store(us);
      (e2 / det).store(vs);
      for (uint32_t rest = mask; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<uint32_t>(std::countr_zero(rest));
        if (!accepts(i, TreeHit{ts[i], us[i], vs[i], primitive})) mask &= ~(1U << i);
      }
    }
    hit_ |= mask;
    t_max_ = select(mask, t_max_, kAny ? WideLanes(-1.0f) : t);
    if (kAny) return;
    e1_ = select(mask, e1_, e1);
    e2_ = select(mask, e2_, e2);
    det_ = select(mask, det_, det);
    for (uint32_t rest = mask; rest != 0; rest &= rest - 1)
      primitive_[static_cast<size_t>(std::countr_zero(rest))] = primitive;
  }

  std::array<uint32_t, 3> axes_;
  WideLanes ox_, oy_, oz_, sx_, sy_, sz_, t_min_, t_max_;
  uint32_t hit_ = 0;                          // mask of the rays for which the others are valid
  WideLanes e1_{0.0f}, e2_{0.0f}, det_{1.0f}; // of the best hits, which are at t_max_
  std::array<uint32_t, kLanes> primitive_{};
};

// Calls finish(ray index, hit) for each ray that hits something, with the nearest hit or, if kAny,
// any hit. The tree is_one_leaf().
template <bool kAny, class Finish>
[[gnu::noinline]] void trace_one_leaf(const Tree& tree, const HitFilter& filter, std::span<const Ray> rays,
                                      const Finish& finish) {
  assert(is_one_leaf(tree));
  const LeafUnit* const leaf = tree.leaves.data() + (tree.root & ~kLeafBit);
  RaysByAxis sorted;
  for (size_t first = 0; first < rays.size(); first += RaysByAxis::kMax) {
    const std::span<const Ray> part = rays.subspan(first, std::min<size_t>(RaysByAxis::kMax, rays.size() - first));
    sorted.sort(part, [&](uint32_t i) { trace_indexed<kAny>(tree, filter, rays, first + i, finish); });
    for (uint32_t axis = 0; axis < 3; ++axis) {
      for (uint32_t at = sorted.begin(axis); at < sorted.end(axis); at += kLanes) {
        if (filter.abandoned()) return;
        const uint8_t* const number = &sorted.number[at];
        LeafRays<kAny> lanes(sorted, at, axis);
        lanes.test(leaf, filter, [&](uint32_t i, const TreeHit& candidate) {
          return CandidateFilter{filter, part[number[i]], tree, kNoId}.accepts(candidate);
        });
        lanes.deliver([&](uint32_t i, const TreeHit& hit) { finish(first + number[i], hit); });
      }
    }
  }
}

} // namespace kindling::accel::kd::KINDLING_SIMD
