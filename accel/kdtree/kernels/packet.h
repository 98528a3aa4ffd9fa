// Packets: sixteen rays, close together and of like direction, go through one tree in step.
//
// All rays of a packet have the same signs of direction, so that they agree which child of a plane is the near one, and the
// same largest axis, so that they shear triangles alike. A wide node is walked plane by plane: a plane that all rays cross
// outside of their intervals costs one comparison for all of them. The interval of a ray that does not enter a cell is empty, stays so
// further down, and needs no mask. In a leaf, triangles that lie to one side of all rays are sorted out first, all at once, by
// interval arithmetic over the packet; the others are tested one by one against all rays. If only few rays have come to a leaf, they are
// tested one by one against all triangles.
//
// Distances to planes, intervals and triangle tests are those of trace_tree(), operation by operation. What may differ: a ray is taken
// through cells that it would not have entered alone if only rounding kept it out; and a triangle that a ray misses by less than the
// rounding of an edge function, which then counts as zero, may be sorted out before. Packets are sixteen wide on every target, so that
// all targets agree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/ray_lanes.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// What the rays of a packet have in common: the signs of the direction in bits 0 to 2 and the number of its largest axis above.
// Rays that hit nothing by definition have a class of their own, the last.
inline constexpr uint32_t kPacketClasses = 25;

// The classes of sixteen rays, a bit of their numbers in each mask.
struct RayClasses {
  std::array<uint32_t, 5> bits;
  uint32_t misses;

  explicit RayClasses(const RayLanes& lanes) {
    for (size_t k = 0; k < 3; ++k) bits[k] = sign_bits(Float16::load(lanes.direction[k]));
    const RayLanes::LargestAxis largest = lanes.largest_axis();
    bits[3] = largest.y;
    bits[4] = ~(largest.x | largest.y) & kAllRays;
    misses = ~lanes.can_hit() & kAllRays;
  }
  // All of one class, and none misses by definition.
  [[nodiscard]] bool uniform() const {
    uint32_t mixed = misses;
    for (const uint32_t b : bits) mixed |= b ^ (0U - (b & 1U));
    return (mixed & kAllRays) == 0;
  }
  [[nodiscard]] uint8_t of(uint32_t ray) const {
    uint32_t number = 0;
    for (uint32_t k = 0; k < bits.size(); ++k) number |= ((bits[k] >> ray) & 1U) << k;
    return static_cast<uint8_t>(((misses >> ray) & 1U) != 0 ? kPacketClasses - 1 : number);
  }
};

template <bool kAny>
class Packet {
 public:
  Packet(const Tree& tree, const HitFilter& filter) : tree_(tree), filter_(filter) {}
  Packet(const Packet&) = delete;
  Packet& operator=(const Packet&) = delete;

  // Loads 1 to 16 rays, of which ray_at(i) refers to number i. To be traced they must be of one class, and not that of misses.
  template <class RayAt>
  void load(uint32_t count, const RayAt& ray_at) {
    lanes_.load(count, ray_at);
    for (uint32_t i = 0; i < count; ++i) ray_[i] = &ray_at(i);
    for (uint32_t i = count; i < kRayLanes; ++i) lanes_.t_max[i] = -1.0f; // empty from the start
    hit_ = 0;
  }
  [[nodiscard]] RayClasses classes() const { return RayClasses(lanes_); }
  // The nearest hit or, if kAny, any, once traced.
  [[nodiscard]] TreeHit hit(uint32_t i) const { return {lanes_.t_max[i], u_[i], v_[i], primitive_[i]}; }
  // Bit i: ray i has a hit.
  [[nodiscard]] uint32_t hits() const { return hit_; }

  void trace() {
    Float16 enter, leave;
    if (!clip_to_bounds(enter, leave)) return;
    prepare_shear();
    ChildWord child = tree_.root;
    uint32_t heap = 1; // number of the plane in its wide node, from 1 as in a binary heap
    uint32_t top = 0;
    while (true) {
      while (static_cast<int32_t>(child) > 0) {
        const WideNode& node = tree_.nodes[child];
        heap = descend(node, child, heap, enter, leave, top);
        child = node.child[heap - kWideLanes];
        heap = 1;
      }
      if (child != kEmptyChild && test_leaf(child, enter, leave)) return;
      const Float16 far = Float16::load(lanes_.t_max);
      do {
        if (top == 0) return;
        const Entry& entry = stack_[--top];
        enter = Float16::load(entry.enter);
        leave = min(Float16::load(entry.leave), far);
        child = entry.child;
        heap = entry.heap;
      } while (at_most(enter, far) == 0);
    }
  }

 private:
  struct alignas(64) Entry {
    float enter[kRayLanes], leave[kRayLanes];
    ChildWord child;
    uint32_t heap;
  };
  // With fewer rays in a leaf than this, rays are tested one by one.
  static constexpr int kFewRays = 4;

  // As clip_to_box(); lanes that miss the box get an empty interval. False if all do.
  bool clip_to_bounds(Float16& enter, Float16& leave) {
    enter = Float16::load(lanes_.t_min);
    leave = Float16::load(lanes_.t_max);
    for (int k = 0; k < 3; ++k) {
      const Float16 reciprocal = Float16(1.0f) / Float16::load(lanes_.direction[k]);
      reciprocal.store(reciprocal_[k]);
      negative_[k] = std::signbit(lanes_.direction[k][0]) ? 1 : 0;
      const Imath::Box3f& box = tree_.clip_bounds;
      const float near = negative_[k] != 0 ? box.max[k] : box.min[k], far = negative_[k] != 0 ? box.min[k] : box.max[k];
      const Float16 origin = Float16::load(lanes_.origin[k]);
      enter = max((Float16(near) - origin) * reciprocal, enter);
      leave = min((Float16(far) - origin) * reciprocal, leave);
    }
    const uint32_t enters = at_most(enter, leave * Float16(kWiden));
    enter = select(enters, Float16(std::numeric_limits<float>::infinity()), min(enter, leave));
    leave = select(enters, Float16(-std::numeric_limits<float>::infinity()), leave);
    return enters != 0;
  }

  // RayShear for all rays, and its range over the packet.
  void prepare_shear() {
    const RayShear first(ray_[0]->origin, ray_[0]->direction);
    kx_ = static_cast<uint32_t>(first.kx);
    ky_ = static_cast<uint32_t>(first.ky);
    kz_ = static_cast<uint32_t>(first.kz);
    const Float16 dz = Float16::load(lanes_.direction[kz_]);
    const Float16 sx = Float16::load(lanes_.direction[kx_]) / dz, sy = Float16::load(lanes_.direction[ky_]) / dz;
    sx.store(sx_);
    sy.store(sy_);
    (Float16(1.0f) / dz).store(sz_);
    const Float16 ox = Float16::load(lanes_.origin[kx_]), oy = Float16::load(lanes_.origin[ky_]),
                  oz = Float16::load(lanes_.origin[kz_]);
    x_range_ = {least(ox), greatest(ox), least(sx), greatest(sx)};
    y_range_ = {least(oy), greatest(oy), least(sy), greatest(sy)};
    z_low_ = least(oz);
    z_high_ = greatest(oz);
  }
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

  // From plane `heap` of a node to one of its children: the heap number of that.
  uint32_t descend(const WideNode& node, ChildWord number, uint32_t heap, Float16& enter, Float16& leave,
                   uint32_t& top) {
    const uint32_t axes = std::bit_cast<uint32_t>(node.planes[kAxesLane]);
    const Float16 widen(kWiden);
    do {
      const uint32_t lane = heap >= 4 ? heap : heap == 1 ? kRootLane : heap - 2;
      const float plane = node.planes[lane];
      const uint32_t axis = (axes >> (2 * lane)) & 3U;
      if (plane == std::numeric_limits<float>::infinity()) { // the branch ends above
        heap *= 2;
        continue;
      }
      const Float16 t = (Float16(plane) - Float16::load(lanes_.origin[axis])) * Float16::load(reciprocal_[axis]);
      const Float16 near_leave = min(t, leave), far_enter = max(t, enter);
      const uint32_t to_near = at_most(enter, near_leave * widen), to_far = at_most(far_enter, leave * widen);
      const uint32_t near = 2 * heap + negative_[axis], far = near ^ 1U;
      if (to_far == 0) {
        leave = near_leave;
        heap = near;
      } else if (to_near == 0) {
        enter = far_enter;
        heap = far;
      } else {
        push(node, number, far, far_enter, leave, top);
        leave = near_leave;
        heap = near;
      }
    } while (heap < kWideLanes);
    return heap;
  }

  void push(const WideNode& node, ChildWord number, uint32_t heap, const Float16& enter, const Float16& leave,
            uint32_t& top) {
    Entry& entry = stack_[top];
    enter.store(entry.enter);
    leave.store(entry.leave);
    const bool outside = heap >= kWideLanes;
    entry.child = outside ? node.child[heap & (kWideLanes - 1)] : number;
    entry.heap = outside ? 1 : heap;
    top += entry.child != kEmptyChild ? 1 : 0;
  }

  // True if all rays are done.
  bool test_leaf(ChildWord child, const Float16& enter, const Float16& leave) {
    const uint32_t active = at_most(enter, leave * Float16(kWiden)) & at_most(enter, Float16::load(lanes_.t_max));
    if (active == 0) return false;
    const LeafUnit* unit = tree_.leaves.data() + (child & ~kLeafBit);
    if (std::popcount(active) < kFewRays) {
      for (uint32_t rest = active; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<uint32_t>(std::countr_zero(rest));
        const CandidateFilter filter{filter_, *ray_[i], tree_, kNoId};
        TreeHit best = ((hit_ >> i) & 1U) != 0 ? hit(i) : TreeHit();
        const uint32_t before = best.primitive;
        const bool any = intersect_leaf<kAny>(unit, shear_of_ray(i), lanes_.t_min[i], filter, lanes_.t_max[i], best);
        if (best.primitive != before) put(i, any ? -1.0f : best.t, best);
      }
    } else {
      while (true) {
        const LeafBlock block(unit);
        test_block(block, active);
        if (block.is_last()) break;
        unit += block.unit_count();
      }
    }
    return kAny && at_least(Float16::load(lanes_.t_max), Float16(0.0f)) == 0;
  }

  // Ranges over the packet of one coordinate of the origin and of the shear along it.
  struct Range {
    float origin_low, origin_high, shear_low, shear_high;
  };
  // Bit i: sheared coordinate i is above zero for all rays, or below it. Rounding is monotonic, so these are bounds of what the
  // rays themselves would compute, without any margin.
  struct Sides {
    uint32_t above, below;
  };
  static Sides sides_of(const float* row, const Range& range, const Float16& z_low, const Float16& z_high) {
    const Float16 p = Float16::load(row), low(range.shear_low), high(range.shear_high), zero(0.0f);
    const Float16 a = low * z_low, b = low * z_high, c = high * z_low, d = high * z_high;
    const Float16 least = (p - Float16(range.origin_high)) - max(max(a, b), max(c, d));
    const Float16 most = (p - Float16(range.origin_low)) - min(min(a, b), min(c, d));
    return {kd::KINDLING_SIMD::above(least, zero), kd::KINDLING_SIMD::above(zero, most)};
  }

  // Bit i: triangle i is not to one side of all rays.
  [[nodiscard]] uint32_t possible(const LeafBlock& block) const {
    const Float16 z = Float16::load(block.row(kz_)), z_low = z - Float16(z_high_), z_high = z - Float16(z_low_);
    const Sides x = sides_of(block.row(kx_), x_range_, z_low, z_high),
                y = sides_of(block.row(ky_), y_range_, z_low, z_high);
    uint32_t out = 0;
    for_each_group(block, [&](uint32_t first, uint32_t count) {
      const WideInt a = WideInt::load(block.corners() + first);
      const WideInt corners = bits_of(a, shift_right<4>(a), shift_right<8>(a));
      const uint32_t missed = subset_of(corners, x.above) | subset_of(corners, x.below) | subset_of(corners, y.above) |
                              subset_of(corners, y.below);
      out |= (~missed & ((1U << count) - 1U)) << first;
      return false;
    });
    return out;
  }

  // The triangles of a block against all rays.
  void test_block(const LeafBlock& block, uint32_t active) {
    uint32_t triangles = possible(block);
    if (triangles == 0) return;
    const Float16 ox = Float16::load(lanes_.origin[kx_]), oy = Float16::load(lanes_.origin[ky_]),
                  oz = Float16::load(lanes_.origin[kz_]), sx = Float16::load(sx_), sy = Float16::load(sy_), zero(0.0f);
    const float *px = block.row(kx_), *py = block.row(ky_), *pz = block.row(kz_);
    const uint16_t* corners = block.corners();
    const auto shear = [&](uint32_t vertex, Float16& x, Float16& y, Float16& z) {
      z = Float16(pz[vertex]) - oz;
      x = (Float16(px[vertex]) - ox) - sx * z;
      y = (Float16(py[vertex]) - oy) - sy * z;
    };
    for (; triangles != 0; triangles &= triangles - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(triangles));
      Float16 ax, ay, az, bx, by, bz, cx, cy, cz;
      shear(corners[i] & 15U, ax, ay, az);
      shear((corners[i] >> 4) & 15U, bx, by, bz);
      shear(corners[i] >> 8, cx, cy, cz);
      const Float16 e0 = cx * by - cy * bx, e1 = ax * cy - ay * cx, e2 = bx * ay - by * ax;
      const uint32_t inside = (at_least(min(min(e0, e1), e2), zero) | at_most(max(max(e0, e1), e2), zero)) & active;
      if (inside == 0) continue;
      const Float16 det = (e0 + e1) + e2;
      const Float16 t = (((e0 * az + e1 * bz) + e2 * cz) * Float16::load(sz_)) / det;
      const uint32_t mask =
          inside & differs(det, zero) & above(t, Float16::load(lanes_.t_min)) & at_most(t, Float16::load(lanes_.t_max));
      if (mask != 0) take(block, i, mask, t, e1 / det, e2 / det);
    }
  }

  // One triangle hit by the rays of the mask.
  void take(const LeafBlock& block, uint32_t triangle, uint32_t mask, const Float16& t, const Float16& u,
            const Float16& v) {
    const uint32_t primitive = block.primitive(triangle);
    // Ties go to the smallest primitive.
    for (uint32_t ties = mask & hit_ & at_least(t, Float16::load(lanes_.t_max)); ties != 0; ties &= ties - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(ties));
      if (primitive >= primitive_[i]) mask &= ~(1U << i);
    }
    if (((block.asking() >> triangle) & 1U) != 0) mask = accepted(primitive, mask, t, u, v);
    const auto keep = [&](float* lanes, const Float16& x) { select(mask, Float16::load(lanes), x).store(lanes); };
    keep(lanes_.t_max, kAny ? Float16(-1.0f) : t);
    keep(u_, u);
    keep(v_, v);
    for (uint32_t i = 0; i < kRayLanes; ++i) primitive_[i] = ((mask >> i) & 1U) != 0 ? primitive : primitive_[i];
    hit_ |= mask;
  }
  // The rays of the mask for which the filter accepts the hit.
  uint32_t accepted(uint32_t primitive, uint32_t mask, const Float16& t, const Float16& u, const Float16& v) const {
    alignas(64) float ts[kRayLanes], us[kRayLanes], vs[kRayLanes];
    t.store(ts);
    u.store(us);
    v.store(vs);
    for (uint32_t rest = mask; rest != 0; rest &= rest - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(rest));
      const CandidateFilter filter{filter_, *ray_[i], tree_, kNoId};
      if (!filter.accepts({ts[i], us[i], vs[i], primitive})) mask &= ~(1U << i);
    }
    return mask;
  }
  void put(uint32_t i, float t_far, const TreeHit& hit) {
    lanes_.t_max[i] = t_far;
    u_[i] = hit.u;
    v_[i] = hit.v;
    primitive_[i] = hit.primitive;
    hit_ |= 1U << i;
  }

  const Tree& tree_;
  const HitFilter& filter_;
  uint32_t kx_ = 0, ky_ = 0, kz_ = 0;  // axes of the sheared space
  uint32_t negative_[3] = {0, 0, 0};   // by axis: 1 if the direction points down it
  Range x_range_{}, y_range_{};        // in the sheared space
  float z_low_ = 0.0f, z_high_ = 0.0f; // of the origins
  RayLanes lanes_;                     // t_max narrows; -1 once any hit will do
  alignas(64) float reciprocal_[3][kRayLanes], sx_[kRayLanes], sy_[kRayLanes], sz_[kRayLanes];
  alignas(64) float u_[kRayLanes], v_[kRayLanes]; // of the best hits, which lie at t_max
  alignas(64) uint32_t primitive_[kRayLanes];
  uint32_t hit_ = 0; // bit i: ray i has one
  const Ray* ray_[kRayLanes];
  Entry stack_[kMaxDepth + 1];
};

// Traces rays in packets: as they come where sixteen in a row are of one class, the others sorted by class; of a class with few
// rays each goes alone through `rest`. Calls finish(number of the ray, hit) for each ray of a packet that hits something.
template <bool kAny, class Finish, class Rest>
inline void trace_packets(const Tree& tree, const HitFilter& filter, std::span<const Ray> rays, const Finish& finish,
                          const Rest& rest) {
  constexpr size_t kMost = 256;   // rays to sort at once: their numbers are kept in bytes
  constexpr uint32_t kFewest = 4; // rays that are worth a packet
  if (tree.root == kEmptyChild) return;
  Packet<kAny> packet(tree, filter);
  for (size_t first = 0; first < rays.size(); first += kMost) {
    const auto count = static_cast<uint32_t>(std::min(kMost, rays.size() - first));
    const Ray* part = &rays[first];
    const auto trace = [&](const auto& number) {
      packet.trace();
      for (uint32_t hits = packet.hits(); hits != 0; hits &= hits - 1) {
        const auto i = static_cast<uint32_t>(std::countr_zero(hits));
        finish(first + number(i), packet.hit(i));
      }
    };
    uint8_t left[kMost], classes[kMost]; // those still to trace
    uint32_t left_count = 0;
    for (uint32_t k = 0; k < count; k += kRayLanes) {
      const uint32_t size = std::min(kRayLanes, count - k);
      packet.load(size, [&](uint32_t i) -> const Ray& { return part[k + i]; });
      const RayClasses found = packet.classes();
      if (size == kRayLanes && found.uniform()) {
        trace([&](uint32_t i) { return k + i; });
        continue;
      }
      for (uint32_t i = 0; i < size; ++i) {
        left[left_count] = static_cast<uint8_t>(k + i);
        classes[left_count++] = found.of(i);
      }
    }
    if (left_count == 0) continue;
    uint8_t order[kMost];
    std::array<uint16_t, kPacketClasses + 1> start{};
    for (uint32_t i = 0; i < left_count; ++i) ++start[classes[i] + 1U];
    for (uint32_t c = 0; c < kPacketClasses; ++c) start[c + 1] = static_cast<uint16_t>(start[c + 1] + start[c]);
    std::array<uint16_t, kPacketClasses + 1> next = start;
    for (uint32_t i = 0; i < left_count; ++i) order[next[classes[i]]++] = left[i];
    for (uint32_t c = 0; c + 1 < kPacketClasses; ++c) {
      for (uint32_t k = start[c]; k < start[c + 1];) {
        const uint32_t size = std::min<uint32_t>(kRayLanes, start[c + 1] - k);
        if (size < kFewest) {
          for (; k < start[c + 1]; ++k) rest(first + order[k]);
          break;
        }
        packet.load(size, [&](uint32_t i) -> const Ray& { return part[order[k + i]]; });
        trace([&](uint32_t i) { return order[k + i]; });
        k += size;
      }
    }
  }
}

} // namespace kindling::accel::kd::KINDLING_SIMD
