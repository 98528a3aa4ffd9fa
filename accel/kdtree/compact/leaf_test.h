// One ray against the blocks of a leaf, triangle by triangle.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/leaf_format.h"
#include "accel/kdtree/tree_hit.h"
#include "accel/motion_keys.h"
#include "accel/ray.h"
#include "accel/triangle.h"

#include <cmath>
#include <cstdint>

namespace kindling::accel::kd::compact {

// Returns a component of a vector by its axis. On a GPU an index would put the vector into memory.
[[nodiscard]] inline float component(const Imath::V3f& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// RayShear(origin, direction) without indices.
[[nodiscard]] inline RayShear shear_of(const Ray& ray) {
  const float ax = std::fabs(ray.direction.x), ay = std::fabs(ray.direction.y), az = std::fabs(ray.direction.z);
  RayShear shear;
  shear.kz = ax > ay ? (ax > az ? 0 : 2) : (ay > az ? 1 : 2);
  shear.kx = shear.kz == 2 ? 0 : shear.kz + 1;
  shear.ky = shear.kx == 2 ? 0 : shear.kx + 1;
  const float dz = component(ray.direction, shear.kz);
  shear.sx = component(ray.direction, shear.kx) / dz;
  shear.sy = component(ray.direction, shear.ky) / dz;
  shear.sz = 1.0f / dz;
  shear.origin = {component(ray.origin, shear.kx), component(ray.origin, shear.ky), component(ray.origin, shear.kz)};
  return shear;
}

// The state of a tree at the time of a ray: nothing for a static one.
struct Static {};
struct Deforming {
  float time = 0.0f;     // within the shutter, in [0, 1]
  float fraction = 0.0f; // within the slice
};

// The vertices of a block as a ray sees them. A vertex is sheared again for each of its triangles:
// keeping sixteen would take 192 bytes of stack.
class StaticVertices {
 public:
  StaticVertices(const LeafBlock& block, const RayShear& ray, Static)
      : ray_(ray), x_(block.row(static_cast<uint32_t>(ray.kx))), y_(block.row(static_cast<uint32_t>(ray.ky))),
        z_(block.row(static_cast<uint32_t>(ray.kz))) {}
  [[nodiscard]] ShearedCorner operator[](uint32_t number) const { return {ray_, x_[number], y_[number], z_[number]}; }

 private:
  const RayShear& ray_;
  const float *x_, *y_, *z_;
};
class MovingVertices {
 public:
  MovingVertices(const MovingBlock& block, const RayShear& ray, const Deforming& at)
      : ray_(ray), x_(block.row(0, static_cast<uint32_t>(ray.kx))), y_(block.row(0, static_cast<uint32_t>(ray.ky))),
        z_(block.row(0, static_cast<uint32_t>(ray.kz))), next_key_(3 * block.vertex_count()) {
    const KeyInterval interval = block.interval_at(at.time);
    first_ = interval.first * next_key_;
    fraction_ = interval.fraction;
  }
  [[nodiscard]] ShearedCorner operator[](uint32_t number) const {
    const uint32_t first = first_ + number, second = first + next_key_;
    return {ray_, between(x_[first], x_[second], fraction_), between(y_[first], y_[second], fraction_),
            between(z_[first], z_[second], fraction_)};
  }

 private:
  const RayShear& ray_;
  const float *x_, *y_, *z_; // rows of the block's first key
  uint32_t next_key_;        // from a row to the same one of the next key
  uint32_t first_;
  float fraction_;
};

template <class Motion>
struct LeafOf;
template <>
struct LeafOf<Static> {
  using Block = LeafBlock;
  using Vertices = StaticVertices;
};
template <>
struct LeafOf<Deforming> {
  using Block = MovingBlock;
  using Vertices = MovingVertices;
};

// The nearest crossing so far in one tree. A block finds out the number of its primitive, and the
// crossing its u and v, when they are needed.
struct NearestCrossing {
  const LeafUnit* unit = nullptr; // the block; null: none
  uint32_t triangle = 0;          // of the block
  ShearedCrossing at;

  [[nodiscard]] bool is_hit() const { return unit != nullptr; }
  template <class Block>
  [[nodiscard]] TreeHit hit() const {
    return {at.t, at.u(), at.v(), Block(unit).primitive(triangle)};
  }
};

// Tests a triangle of a block, wherever on the ray it is hit. Returns true, and sets `nearest`, if
// it counts: if it is not beyond t_far; of hits at equal distance the smallest primitive does.
// `accepts(candidate)` decides about meshes that are not opaque.
template <class Motion, class Accepts>
[[gnu::always_inline]] inline bool test_triangle(const LeafUnit* unit, uint32_t triangle, const Motion& motion,
                                                 const RayShear& ray, float t_min, float t_far,
                                                 NearestCrossing& nearest, const Accepts& accepts) {
  using Block = typename LeafOf<Motion>::Block;
  const Block block(unit);
  const typename LeafOf<Motion>::Vertices vertices(block, ray, motion);
  const uint32_t corners = block.corners()[triangle];
  NearestCrossing candidate{unit, triangle, {}};
  if (!find_crossing(vertices[corners & 15U], vertices[(corners >> 4) & 15U], vertices[(corners >> 8) & 15U], ray.sz,
                     t_min, t_far, candidate.at))
    return false;
  if (nearest.is_hit() && candidate.at.t == nearest.at.t &&
      block.primitive(triangle) >= Block(nearest.unit).primitive(nearest.triangle))
    return false;
  if (((block.filtered() >> triangle) & 1U) != 0 && !accepts(candidate.template hit<Block>())) return false;
  nearest = candidate;
  return true;
}

} // namespace kindling::accel::kd::compact
