// Sixteen rays as a structure of arrays.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/simd.h"

namespace kindling::accel::kd::KINDLING_SIMD {

inline constexpr uint32_t kRayLanes = 16;
inline constexpr uint32_t kAllRays = (1U << kRayLanes) - 1;

// See widening.h.
inline Lanes16 finite_reciprocal(const Lanes16& direction) {
  const Lanes16 max_float(std::numeric_limits<float>::max()), lowest(std::numeric_limits<float>::lowest());
  return max(min(Lanes16(1.0f) / direction, max_float), lowest);
}

struct alignas(64) RayLanes {
  float origin[3][kRayLanes], direction[3][kRayLanes];
  float t_min[kRayLanes], t_max[kRayLanes]; // at least zero; at most the largest float

  // Loads `count` rays, 1 to 16; ray_at(i) refers to ray i. The last is repeated.
  template <class RayAt>
  void load(uint32_t count, const RayAt& ray_at) {
    assert(count >= 1 && count <= kRayLanes);
    const auto ray = [&](uint32_t i) -> const Ray& { return ray_at(std::min(i, count - 1)); };
    transpose16([&](uint32_t i) { return load_origin(ray(i)); }, {origin[0], origin[1], origin[2], t_min});
    transpose16([&](uint32_t i) { return load_direction(ray(i)); }, {direction[0], direction[1], direction[2], t_max});
    // NaN is preserved for can_hit().
    max(Lanes16(0.0f), Lanes16::load(t_min)).store(t_min);
    min(Lanes16(std::numeric_limits<float>::max()), Lanes16::load(t_max)).store(t_max);
  }

  // Writes origin, direction and interval of the rays of a mask.
  void store(uint32_t mask, Ray* rays) const {
    std::array<Ray, kRayLanes> all;
    const auto scatter = [&](const float(&xyz)[3][kRayLanes], const float* w, size_t offset) {
      scatter16(Lanes16::load(xyz[0]), Lanes16::load(xyz[1]), Lanes16::load(xyz[2]), Lanes16::load(w),
                [&](uint32_t i) { return reinterpret_cast<float*>(&all[i]) + offset / sizeof(float); });
    };
    scatter(origin, t_min, offsetof(Ray, origin));
    scatter(direction, t_max, offsetof(Ray, direction));
    for (; mask != 0; mask &= mask - 1) {
      const auto i = static_cast<size_t>(std::countr_zero(mask));
      rays[i] = all[i];
    }
  }

  // Bit i is can_hit(ray i).
  [[nodiscard]] uint32_t can_hit() const {
    const Lanes16 zero(0.0f), x = Lanes16::load(direction[0]), y = Lanes16::load(direction[1]),
                              z = Lanes16::load(direction[2]), near = Lanes16::load(t_min), far = Lanes16::load(t_max);
    const Lanes16 sum = (magnitude(Lanes16::load(origin[0])) + magnitude(Lanes16::load(origin[1])) +
                         magnitude(Lanes16::load(origin[2]))) +
                        (magnitude(x) + magnitude(y) + magnitude(z));
    return at_most(sum, Lanes16(kMaxCoordinate)) & (differs(x, zero) | differs(y, zero) | differs(z, zero)) &
           above(far, near);
  }

  // Bit i is is_short(direction of ray i).
  [[nodiscard]] uint32_t is_short() const {
    const Lanes16 limit(kShortDirection);
    uint32_t bits = kAllRays;
    for (const auto& lane : direction) bits &= above(limit, magnitude(Lanes16::load(lane)));
    return bits;
  }

  // Bit i is set in `x` or `y` if that is the largest axis of ray i's direction; else it is z. Ties
  // are resolved as in RayShear.
  struct LargestAxis {
    uint32_t x, y;
  };
  [[nodiscard]] LargestAxis largest_axis() const {
    const Lanes16 x = magnitude(Lanes16::load(direction[0])), y = magnitude(Lanes16::load(direction[1])),
                  z = magnitude(Lanes16::load(direction[2]));
    const uint32_t x_over_y = above(x, y);
    return {x_over_y & above(x, z), ~x_over_y & above(y, z) & kAllRays};
  }
};

} // namespace kindling::accel::kd::KINDLING_SIMD
