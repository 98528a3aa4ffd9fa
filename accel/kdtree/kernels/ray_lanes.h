// Sixteen rays as a structure of arrays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/simd.h"

namespace kindling::accel::kd::KINDLING_SIMD {

inline constexpr uint32_t kRayLanes = 16;
inline constexpr uint32_t kAllRays = (1U << kRayLanes) - 1;

// Four quads to four places, each of which gets one lane of all.
inline void transpose(Quad a, Quad b, Quad c, Quad d, const std::array<float*, 4>& out) {
  using Index = int32_t __attribute__((vector_size(16)));
  const Quad ab_low = __builtin_shuffle(a, b, Index{0, 4, 1, 5}), ab_high = __builtin_shuffle(a, b, Index{2, 6, 3, 7});
  const Quad cd_low = __builtin_shuffle(c, d, Index{0, 4, 1, 5}), cd_high = __builtin_shuffle(c, d, Index{2, 6, 3, 7});
  const std::array<Quad, 4> lanes = {
      __builtin_shuffle(ab_low, cd_low, Index{0, 1, 4, 5}), __builtin_shuffle(ab_low, cd_low, Index{2, 3, 6, 7}),
      __builtin_shuffle(ab_high, cd_high, Index{0, 1, 4, 5}), __builtin_shuffle(ab_high, cd_high, Index{2, 3, 6, 7})};
  for (size_t i = 0; i < 4; ++i) std::memcpy(out[i], &lanes[i], sizeof(Quad));
}

struct alignas(64) RayLanes {
  float origin[3][kRayLanes], direction[3][kRayLanes];
  float t_min[kRayLanes], t_max[kRayLanes]; // t_min not below zero

  // `count` rays, 1 to 16, of which ray_at(i) refers to number i; the last is repeated.
  template <class RayAt>
  void load(uint32_t count, const RayAt& ray_at) {
    for (uint32_t i = 0; i < kRayLanes; i += 4) {
      const Ray &a = ray_at(std::min(i, count - 1)), &b = ray_at(std::min(i + 1, count - 1)),
                &c = ray_at(std::min(i + 2, count - 1)), &d = ray_at(std::min(i + 3, count - 1));
      transpose(origin_quad(a), origin_quad(b), origin_quad(c), origin_quad(d),
                {origin[0] + i, origin[1] + i, origin[2] + i, t_min + i});
      transpose(direction_quad(a), direction_quad(b), direction_quad(c), direction_quad(d),
                {direction[0] + i, direction[1] + i, direction[2] + i, t_max + i});
    }
    // NaN stays, so that can_hit() sees it.
    max(Float16(0.0f), Float16::load(t_min)).store(t_min);
  }

  // Bit i: can_hit(ray i).
  [[nodiscard]] uint32_t can_hit() const {
    const Float16 zero(0.0f), x = Float16::load(direction[0]), y = Float16::load(direction[1]),
                              z = Float16::load(direction[2]), near = Float16::load(t_min), far = Float16::load(t_max);
    const Float16 sum = (magnitude(Float16::load(origin[0])) + magnitude(Float16::load(origin[1])) +
                         magnitude(Float16::load(origin[2]))) +
                        (magnitude(x) + magnitude(y) + magnitude(z));
    return at_most(sum, Float16(kLargestCoordinate)) & (differs(x, zero) | differs(y, zero) | differs(z, zero)) &
           above(far, near);
  }

  // Bit i: may_lie_in_plane(direction of ray i).
  [[nodiscard]] uint32_t may_lie_in_plane() const {
    const Float16 least(std::numeric_limits<float>::min());
    uint32_t bits = 0;
    for (const auto& lane : direction) bits |= above(least, magnitude(Float16::load(lane)));
    return bits;
  }

  // Bit i: the largest axis of the direction of ray i is x, or y, or else it is z; ties as in RayShear.
  struct LargestAxis {
    uint32_t x, y;
  };
  [[nodiscard]] LargestAxis largest_axis() const {
    const Float16 x = magnitude(Float16::load(direction[0])), y = magnitude(Float16::load(direction[1])),
                  z = magnitude(Float16::load(direction[2]));
    const uint32_t x_over_y = above(x, y);
    return {x_over_y & above(x, z), ~x_over_y & above(y, z) & kAllRays};
  }
};

} // namespace kindling::accel::kd::KINDLING_SIMD
