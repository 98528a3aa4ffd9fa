// The leaf test: intersects one ray with the triangles of a block, and accepts hits.
//
// The arithmetic is that of accel/triangle.h, operation by operation. The shear onto the largest
// axis is free here, because it only selects rows of the block. Vertices are translated and sheared
// once, then selected by the triangles. Several walks share this code, which
// must be inlined in each.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/simd.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// RayShear(origin, direction) without branches, which mixed rays would mispredict.
inline RayShear shear_of(const Ray& ray) {
  // Indexed by ax > ay, ax > az, ay > az in bits 0 to 2: the axes in the order x, y, z of the
  // sheared space.
  static constexpr uint8_t kAxes[8][3] = {{0, 1, 2}, {0, 1, 2}, {0, 1, 2}, {1, 2, 0},
                                          {2, 0, 1}, {0, 1, 2}, {2, 0, 1}, {1, 2, 0}};
  const Imath::V3f& d = ray.direction;
  const float ax = std::fabs(d.x), ay = std::fabs(d.y), az = std::fabs(d.z);
  const auto& axes =
      kAxes[static_cast<uint32_t>(ax > ay) | static_cast<uint32_t>(ax > az) << 1 | static_cast<uint32_t>(ay > az) << 2];
  RayShear shear;
  shear.kx = axes[0];
  shear.ky = axes[1];
  shear.kz = axes[2];
  const float dz = d[shear.kz];
  Float4 quotients = Float4{d.x, d.y, d.z, 1.0f} / Float4{dz, dz, dz, dz};
  float shears[4];
  std::memcpy(shears, &quotients, sizeof(Float4));
  shear.sx = shears[shear.kx];
  shear.sy = shears[shear.ky];
  shear.sz = shears[3];
  shear.origin = {ray.origin[shear.kx], ray.origin[shear.ky], ray.origin[shear.kz]};
  return shear;
}

// The vertices of a block in the sheared space of a ray.
struct ShearedVertices {
  Lanes16 x, y, z;

  [[gnu::always_inline]] ShearedVertices(const LeafBlock& block, const RayShear& ray)
      : x(Lanes16::load(block.row(static_cast<uint32_t>(ray.kx))) - Lanes16(ray.origin.x)),
        y(Lanes16::load(block.row(static_cast<uint32_t>(ray.ky))) - Lanes16(ray.origin.y)),
        z(Lanes16::load(block.row(static_cast<uint32_t>(ray.kz))) - Lanes16(ray.origin.z)) {
    x = x - Lanes16(ray.sx) * z;
    y = y - Lanes16(ray.sy) * z;
  }
  // Vertices at a time, interpolated between two keys as by between() in accel/motion.h.
  [[gnu::always_inline]] ShearedVertices(const MovingBlock& block, const RayShear& ray, float time) {
    const KeyInterval at = block.interval_at(time);
    const auto row = [&](int axis, float origin) {
      const Lanes16 first = Lanes16::load(block.row(at.first, static_cast<uint32_t>(axis))),
                    second = Lanes16::load(block.row(at.first + 1, static_cast<uint32_t>(axis)));
      return (first + (second - first) * Lanes16(at.fraction)) - Lanes16(origin);
    };
    z = row(ray.kz, ray.origin.z);
    x = row(ray.kx, ray.origin.x) - Lanes16(ray.sx) * z;
    y = row(ray.ky, ray.origin.y) - Lanes16(ray.sy) * z;
  }
};

// Edge functions of up to kLanes triangles. Bit i of `inside` is set if the line of the ray is
// inside triangle i. That includes det = 0, where all three edge functions are zero: the distance
// is 0 / 0 then, and NaN lies in no interval.
struct TriangleTest {
  WideLanes e0, e1, e2, det;
  WideIntLanes a, b, c; // corners
  uint32_t inside;

  [[gnu::always_inline]] TriangleTest(const ShearedVertices& vertices, const uint16_t* corners, uint32_t count) {
    assert(count >= 1 && count <= kLanes);
    a = WideIntLanes::load(corners);
    b = shift_right<4>(a);
    c = shift_right<8>(a);
    const WideLanes ax = pick(vertices.x, a), bx = pick(vertices.x, b), cx = pick(vertices.x, c);
    const WideLanes ay = pick(vertices.y, a), by = pick(vertices.y, b), cy = pick(vertices.y, c);
    const WideLanes zero(0.0f);
    e0 = difference_of_products(cx, by, cy, bx);
    e1 = difference_of_products(ax, cy, ay, cx);
    e2 = difference_of_products(bx, ay, by, ax);
    det = (e0 + e1) + e2; // NaN if any of them is
    inside = (at_least(min(min(e0, e1), e2), zero) | at_most(max(max(e0, e1), e2), zero)) &
             ((1U << count) - 1U); // lanes past the last triangle are undefined
  }
  // Returns distances along the ray.
  [[nodiscard, gnu::always_inline]] WideLanes distance(const ShearedVertices& vertices, float sz) const {
    const WideLanes az = pick(vertices.z, a), bz = pick(vertices.z, b), cz = pick(vertices.z, c);
    return (((e0 * az + e1 * bz) + e2 * cz) * WideLanes(sz)) / det;
  }
};

// Test results of a block's triangles, indexed by triangle.
struct alignas(64) TestedBlock {
  std::array<float, kBlockTriangles> t, e1, e2, det;

  void store(uint32_t first, WideLanes distance, const TriangleTest& test) {
    distance.store(&t[first]);
    test.e1.store(&e1[first]);
    test.e2.store(&e2[first]);
    test.det.store(&det[first]);
  }
};

// Processes the hit triangles of a block, given as a mask. Nearest hit: narrows t_far and sets
// best. Any hit: returns true at the first accepted one.
template <bool kAny, class Block>
inline bool take_candidates(const Block& block, uint32_t hit, const TestedBlock& tested, const CandidateFilter& filter,
                            float& t_far, TreeHit& best) {
  for (; hit != 0; hit &= hit - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(hit));
    const float t = tested.t[i];
    if (t > t_far) continue;
    const uint32_t primitive = block.primitive(i);
    // Ties go to the smallest primitive, as in the oracle; the same one may occur again in another
    // leaf.
    if (best.is_hit() && t == best.t && primitive >= best.primitive) continue;
    const TreeHit candidate{t, tested.e1[i] / tested.det[i], tested.e2[i] / tested.det[i], primitive};
    if (((block.filtered() >> i) & 1U) != 0 && !filter.accepts(candidate)) continue;
    best = candidate;
    t_far = candidate.t;
    if (kAny) return true;
  }
  return false;
}

// Calls f(first triangle, count) for groups of triangles that are tested at once; ends early if it
// returns true.
template <class Block, class F>
inline bool for_each_group(const Block& block, const F& f) {
  const uint32_t count = block.triangle_count();
  if constexpr (kLanes >= kBlockTriangles) return f(0U, count);
  for (uint32_t first = 0; first < count; first += kLanes)
    if (f(first, std::min(kLanes, count - first))) return true;
  return false;
}

// Tag for a static tree; carries no state.
struct Static {
  using Block = LeafBlock;
  [[nodiscard]] static ShearedVertices vertices_of(const LeafBlock& block, const RayShear& ray) { return {block, ray}; }
};
// The state of a deforming tree at a time of its slice of the shutter.
struct Deforming {
  using Block = MovingBlock;
  float time = 0.0f;     // within the shutter
  float fraction = 0.0f; // within the slice
  [[nodiscard]] ShearedVertices vertices_of(const MovingBlock& block, const RayShear& ray) const {
    return {block, ray, time};
  }
};

// Tests all blocks of a leaf. Nearest hit: narrows t_far and sets best. Any hit: returns true at
// the first. Hits outside the cell of the leaf count too.
template <bool kAny, class Motion>
[[gnu::always_inline]] inline bool intersect_leaf(const LeafUnit* unit, Motion motion, const RayShear& ray, float t_min,
                                                  const CandidateFilter& filter, float& t_far, TreeHit& best) {
  // The size of a leaf is stored in its first line, and most leaves span several.
  for (size_t line = 1; line < 5; ++line) prefetch(unit + kUnitsPerLine * line);
  while (true) {
    const typename Motion::Block block(unit);
    const ShearedVertices vertices = motion.vertices_of(block, ray);
    const bool ends = for_each_group(block, [&](uint32_t first, uint32_t count) {
      const TriangleTest test(vertices, block.corners() + first, count);
      // Computed even if the line misses every triangle: that is true of half of all blocks and
      // cannot be predicted.
      const WideLanes t = test.distance(vertices, ray.sz);
      const uint32_t mask = test.inside & above(t, WideLanes(t_min)) & at_most(t, WideLanes(t_far));
      if (mask == 0) return false;
      TestedBlock tested;
      tested.store(first, t, test);
      return take_candidates<kAny>(block, mask << first, tested, filter, t_far, best);
    });
    if (ends) return true;
    const uint32_t next = block.units_to_next();
    if (next == 0) return false;
    unit += next;
  }
}

} // namespace kindling::accel::kd::KINDLING_SIMD
