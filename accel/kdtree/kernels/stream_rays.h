// Rays prepared for a stream: per-ray data in one cache line, computed sixteen at a time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/ray_lanes.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

struct alignas(64) PreparedRay {
  std::array<float, 3> origin;
  float t_min;
  std::array<float, 3> reciprocal;
  float t_far; // -1 for blocked any-hit rays
  std::array<float, 3> shear;
  uint32_t axes;      // axes of the sheared space: kx, ky, kz in a byte each from the lowest up
  float enter, leave; // interval in the tree's box
  std::array<float, 2> spare;

  [[nodiscard]] RayShear ray_shear() const {
    const uint32_t kx = axes & 3U, ky = (axes >> 8) & 3U, kz = axes >> 16;
    RayShear out;
    out.kx = static_cast<int>(kx);
    out.ky = static_cast<int>(ky);
    out.kz = static_cast<int>(kz);
    out.sx = shear[0];
    out.sy = shear[1];
    out.sz = shear[2];
    out.origin = {origin[kx], origin[ky], origin[kz]};
    return out;
  }
};
static_assert(sizeof(PreparedRay) == 64);

struct PreparedRays {
  std::array<PreparedRay, kRayLanes> rays;
  uint32_t enter;    // bit i: ray i can hit something, enters the tree's box, and is not in `in_plane`
  uint32_t in_plane; // bit i: ray i enters likewise, but may_lie_in_plane()

  // Prepares 1 to 16 rays.
  void prepare(const Tree& tree, std::span<const Ray> from) {
    const auto count = static_cast<uint32_t>(from.size());
    RayLanes lanes;
    lanes.load(count, [&](uint32_t i) -> const Ray& { return from[i]; });
    Lanes16 first = Lanes16::load(lanes.t_min), last = Lanes16::load(lanes.t_max);
    const Lanes16 zero(0.0f), one(1.0f), near = first, far = last;
    Lanes16 reciprocal[3];
    for (int k = 0; k < 3; ++k) { // as in clip_to_box()
      const Lanes16 origin = Lanes16::load(lanes.origin[k]), direction = Lanes16::load(lanes.direction[k]);
      reciprocal[k] = one / direction;
      const uint32_t down = sign_bits(direction);
      const Lanes16 low(tree.clip_bounds.min[k]), high(tree.clip_bounds.max[k]);
      first = max((select(down, low, high) - origin) * reciprocal[k], first);
      last = min((select(down, high, low) - origin) * reciprocal[k], last);
    }
    const uint32_t entering = lanes.can_hit() & at_most(first, last * Lanes16(kWiden)) & ((1U << count) - 1U);
    in_plane = entering & lanes.may_lie_in_plane();
    enter = entering & ~in_plane;
    const RayLanes::LargestAxis largest = lanes.largest_axis();
    const auto rotate = [&](const Lanes16& if_x, const Lanes16& if_y, const Lanes16& if_z) {
      return select(largest.x, select(largest.y, if_z, if_y), if_x);
    };
    const Lanes16 x = Lanes16::load(lanes.direction[0]), y = Lanes16::load(lanes.direction[1]),
                  z = Lanes16::load(lanes.direction[2]), dz = rotate(x, y, z);
    const Lanes16 axes = rotate(Lanes16(std::bit_cast<float>(0x000201U)), Lanes16(std::bit_cast<float>(0x010002U)),
                                Lanes16(std::bit_cast<float>(0x020100U)));
    const Lanes16 shear[3] = {rotate(y, z, x) / dz, rotate(z, x, y) / dz, one / dz};
    const Lanes16 interval[3] = {min(first, last), last, zero};
    scatter(lanes.origin, near, offsetof(PreparedRay, origin));
    scatter(reciprocal, far, offsetof(PreparedRay, reciprocal));
    scatter(shear, axes, offsetof(PreparedRay, shear));
    scatter(interval, zero, offsetof(PreparedRay, enter));
  }

 private:
  // Writes four lanes of sixteen rays, one Float4 to each ray.
  void scatter(const float (&xyz)[3][kRayLanes], const Lanes16& w, size_t offset) {
    alignas(64) float last[kRayLanes];
    w.store(last);
    for (uint32_t i = 0; i < kRayLanes; i += 4) {
      std::array<float*, 4> out;
      for (uint32_t k = 0; k < 4; ++k) out[k] = reinterpret_cast<float*>(&rays[i + k]) + offset / sizeof(float);
      Float4 rows[4];
      for (uint32_t k = 0; k < 3; ++k) std::memcpy(&rows[k], xyz[k] + i, sizeof(Float4));
      std::memcpy(&rows[3], last + i, sizeof(Float4));
      transpose(rows[0], rows[1], rows[2], rows[3], out);
    }
  }
  void scatter(const Lanes16 (&xyz)[3], const Lanes16& w, size_t offset) {
    alignas(64) float stored[3][kRayLanes];
    for (uint32_t k = 0; k < 3; ++k) xyz[k].store(stored[k]);
    scatter(stored, w, offset);
  }
};

} // namespace kindling::accel::kd::KINDLING_SIMD
