// Rays prepared for a stream: per-ray data in one cache line, computed sixteen at a time.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/ray_lanes.h"
#include "accel/kdtree/kernels/traversal.h"

namespace kindling::accel::kd::KINDLING_SIMD {

// The part of a ray that a stream reads in every step.
struct alignas(16) StreamRay {
  std::array<float, 3> origin;
  float t_min;
  std::array<float, 3> reciprocal;
  float t_far; // -1 for blocked any-hit rays
  std::array<float, 3> shear;
  uint8_t kx, ky, kz; // axes of the sheared space
  uint8_t top;        // number of frames on the ray's stack; set by the stream

  [[nodiscard]] RayShear ray_shear() const {
    RayShear out;
    out.kx = kx;
    out.ky = ky;
    out.kz = kz;
    out.sx = shear[0];
    out.sy = shear[1];
    out.sz = shear[2];
    out.origin = {origin[kx], origin[ky], origin[kz]};
    return out;
  }
};
static_assert(sizeof(StreamRay) == 48);
static_assert(std::endian::native == std::endian::little); // PreparedRays::axes()

struct PreparedRays {
  std::array<StreamRay, kRayLanes> rays;
  uint32_t valid; // bit i: ray i can hit something and is not in `apart`
  uint32_t enter; // bit i: ray i is valid and enters the tree's box
  uint32_t apart; // bit i: ray i can hit something, but its direction is_short()

  // Prepares 1 to 16 rays for trees with these bounds: one box, or sixteen with low(axis) and
  // high(axis).
  void prepare(std::span<const Ray> from, const Imath::Box3f& bounds) {
    struct OneBox {
      const Imath::Box3f& box;
      [[nodiscard]] Lanes16 low(int axis) const { return Lanes16(box.min[axis]); }
      [[nodiscard]] Lanes16 high(int axis) const { return Lanes16(box.max[axis]); }
    };
    prepare(from, OneBox{bounds});
  }
  template <class Bounds>
  void prepare(std::span<const Ray> from, const Bounds& bounds) {
    const auto count = static_cast<uint32_t>(from.size());
    RayLanes lanes;
    lanes.load(count, [&](uint32_t i) -> const Ray& { return from[i]; });
    Lanes16 first = Lanes16::load(lanes.t_min), last = Lanes16::load(lanes.t_max);
    const Lanes16 one(1.0f), near = first, far = last;
    Lanes16 reciprocal[3];
    for (int k = 0; k < 3; ++k) {
      const Lanes16 origin = Lanes16::load(lanes.origin[k]), direction = Lanes16::load(lanes.direction[k]);
      reciprocal[k] = finite_reciprocal(direction);
      const uint32_t down = sign_bits(direction);
      const Lanes16 low = bounds.low(k), high = bounds.high(k);
      first = max((select(down, low, high) - origin) * reciprocal[k], first);
      last = min((select(down, high, low) - origin) * reciprocal[k], last);
    }
    const uint32_t tested = lanes.can_hit() & ((1U << count) - 1U);
    apart = tested & lanes.is_short();
    valid = tested & ~apart;
    enter = valid & at_most(first, last * Lanes16(kWiden));
    const RayLanes::LargestAxis largest = lanes.largest_axis();
    const auto rotate = [&](const Lanes16& if_x, const Lanes16& if_y, const Lanes16& if_z) {
      return select(largest.x, select(largest.y, if_z, if_y), if_x);
    };
    const Lanes16 x = Lanes16::load(lanes.direction[0]), y = Lanes16::load(lanes.direction[1]),
                  z = Lanes16::load(lanes.direction[2]), dz = rotate(x, y, z);
    const Lanes16 xyz = axes(0, 1, 2), yzx = axes(1, 2, 0), zxy = axes(2, 0, 1);
    const Lanes16 shear[3] = {rotate(y, z, x) / dz, rotate(z, x, y) / dz, one / dz};
    const Lanes16 origin[3] = {Lanes16::load(lanes.origin[0]), Lanes16::load(lanes.origin[1]),
                               Lanes16::load(lanes.origin[2])};
    scatter(origin, near, offsetof(StreamRay, origin));
    scatter(reciprocal, far, offsetof(StreamRay, reciprocal));
    scatter(shear, rotate(yzx, zxy, xyz), offsetof(StreamRay, shear));
  }

 private:
  // The axes of a sheared space as the bytes kx, ky, kz and 0 of each lane.
  static Lanes16 axes(uint32_t kx, uint32_t ky, uint32_t kz) {
    return Lanes16(std::bit_cast<float>(kx | ky << 8 | kz << 16));
  }
  // Writes four lanes of sixteen rays, four floats to each ray.
  void scatter(const Lanes16 (&xyz)[3], const Lanes16& w, size_t offset) {
    scatter16(xyz[0], xyz[1], xyz[2], w,
              [&](uint32_t i) { return reinterpret_cast<float*>(&rays[i]) + offset / sizeof(float); });
  }
};

} // namespace kindling::accel::kd::KINDLING_SIMD
