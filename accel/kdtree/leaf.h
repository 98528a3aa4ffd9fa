// The leaf test: one ray against blocks of eight triangles, and what counts as a hit.
//
// The arithmetic is that of accel/triangle.h, operation by operation; the shear onto the largest axis costs nothing here,
// because it only chooses the rows of the block.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/node.h"
#include "accel/kdtree/simd8.h"
#include "accel/triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kindling::accel::kd {

// Best hit so far in one tree.
struct TreeHit {
  float t = 0.0f, u = 0.0f, v = 0.0f;
  uint32_t primitive = kNoId;

  [[nodiscard]] bool is_hit() const { return primitive != kNoId; }
};

// Resolves candidates of one tree and asks the hit filter about them.
struct CandidateFilter {
  const HitFilter& filter;
  const Ray& world_ray;
  const Tree& tree;
  uint32_t instance; // kNoId: that of the geometry

  [[nodiscard]] Hit resolve(const TreeHit& candidate) const {
    const Geometry& geometry = tree.geometry_of(candidate.primitive);
    return {candidate.t,         candidate.u,
            candidate.v,         instance == kNoId ? geometry.instance : instance,
            geometry.mesh_index, candidate.primitive - geometry.first_primitive};
  }
  [[nodiscard]] bool accepts(const TreeHit& candidate) const {
    return filter.accept == nullptr || filter.accept(filter.context, world_ray, resolve(candidate));
  }
};

// RayShear(origin, direction) without branches, which for mixed rays would be mispredicted.
inline RayShear shear_of(const Ray& ray) {
  // By ax > ay, ax > az, ay > az in bits 0 to 2: the axes in the order x, y, z of the sheared space.
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
  shear.sz = 1.0f / d[shear.kz];
  shear.sx = d[shear.kx] / d[shear.kz];
  shear.sy = d[shear.ky] / d[shear.kz];
  shear.origin = {ray.origin[shear.kx], ray.origin[shear.ky], ray.origin[shear.kz]};
  return shear;
}

// Takes the candidates `mask` of a block; out of line of the common case that there is none.
template <bool kAny>
inline bool take_candidates(const LeafBlock& block, uint32_t mask, Float8 t, Float8 e1, Float8 e2, Float8 det,
                            const CandidateFilter& filter, float& t_far, TreeHit& best) {
  alignas(32) float ts[8], e1s[8], e2s[8], dets[8];
  t.store(ts);
  e1.store(e1s);
  e2.store(e2s);
  det.store(dets);
  for (; mask != 0; mask &= mask - 1) {
    const auto lane = static_cast<uint32_t>(std::countr_zero(mask));
    if (ts[lane] > t_far) continue;
    const uint32_t primitive = block.primitive[lane] & kPrimitiveMask;
    // Ties go to the smallest primitive, as in the oracle; the same one may come up again from another leaf.
    if (best.is_hit() && ts[lane] == best.t && primitive >= best.primitive) continue;
    const TreeHit candidate{ts[lane], e1s[lane] / dets[lane], e2s[lane] / dets[lane], primitive};
    if ((block.primitive[lane] & kAskFilter) != 0 && !filter.accepts(candidate)) continue;
    best = candidate;
    t_far = candidate.t;
    if (kAny) return true;
  }
  return false;
}

// A ray against the eight triangles of a block: edge functions and their sum, and where the line of the ray is inside.
struct BlockTest {
  Float8 az, bz, cz, e0, e1, e2, det;
  Mask8 inside;

  BlockTest(const LeafBlock& block, const RayShear& ray) {
    const Float8 ox(ray.origin.x), oy(ray.origin.y), oz(ray.origin.z), sx(ray.sx), sy(ray.sy), zero(0.0f);
    const auto& p = block.vertex;
    az = Float8::load(p[0][ray.kz]) - oz;
    bz = Float8::load(p[1][ray.kz]) - oz;
    cz = Float8::load(p[2][ray.kz]) - oz;
    const Float8 ax = (Float8::load(p[0][ray.kx]) - ox) - sx * az, ay = (Float8::load(p[0][ray.ky]) - oy) - sy * az;
    const Float8 bx = (Float8::load(p[1][ray.kx]) - ox) - sx * bz, by = (Float8::load(p[1][ray.ky]) - oy) - sy * bz;
    const Float8 cx = (Float8::load(p[2][ray.kx]) - ox) - sx * cz, cy = (Float8::load(p[2][ray.ky]) - oy) - sy * cz;
    e0 = cx * by - cy * bx;
    e1 = ax * cy - ay * cx;
    e2 = bx * ay - by * ax;
    det = (e0 + e1) + e2; // NaN if any of them is
    inside = ((min(min(e0, e1), e2) >= zero) | (max(max(e0, e1), e2) <= zero)) & differs(det, zero);
  }
  [[nodiscard]] Float8 t(float sz) const { return (((e0 * az + e1 * bz) + e2 * cz) * Float8(sz)) / det; }
};

// Nearest hit: narrows t_far and sets best. Any hit: returns true at the first. Hits outside the cell of the leaf count too.
template <bool kAny>
inline bool intersect_leaf(const LeafBlock* block, uint32_t count, const RayShear& ray, float t_min,
                           const CandidateFilter& filter, float& t_far, TreeHit& best) {
  for (const LeafBlock* end = block + count; block != end; ++block) {
    const BlockTest test(*block, ray);
    if (test.inside.bits() == 0) continue;
    const Float8 t = test.t(ray.sz);
    const uint32_t mask = (test.inside & (t > Float8(t_min)) & (t <= Float8(t_far))).bits();
    if (mask != 0 && take_candidates<kAny>(*block, mask, t, test.e1, test.e2, test.det, filter, t_far, best))
      return true;
  }
  return false;
}

} // namespace kindling::accel::kd
