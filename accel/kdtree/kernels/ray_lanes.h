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

#if KINDLING_SIMD_LEVEL == 512
inline __m512 four_quads(Quad a, Quad b, Quad c, Quad d) {
  const __m512 ab = _mm512_castps256_ps512(_mm256_insertf128_ps(_mm256_castps128_ps256(a), b, 1));
  return _mm512_insertf32x8(ab, _mm256_insertf128_ps(_mm256_castps128_ps256(c), d, 1), 1);
}
// Four times four quads at once, where quad k of register i is number 4 k + i.
inline void transpose(const __m512 (&v)[4], const std::array<float*, 4>& out) {
  const __m512 ab_low = _mm512_unpacklo_ps(v[0], v[1]), ab_high = _mm512_unpackhi_ps(v[0], v[1]);
  const __m512 cd_low = _mm512_unpacklo_ps(v[2], v[3]), cd_high = _mm512_unpackhi_ps(v[2], v[3]);
  _mm512_store_ps(out[0], _mm512_shuffle_ps(ab_low, cd_low, 0x44));
  _mm512_store_ps(out[1], _mm512_shuffle_ps(ab_low, cd_low, 0xee));
  _mm512_store_ps(out[2], _mm512_shuffle_ps(ab_high, cd_high, 0x44));
  _mm512_store_ps(out[3], _mm512_shuffle_ps(ab_high, cd_high, 0xee));
}
#endif

// Bit i: the number whose bits lane i has, of sixteen aligned ones, is above x.
inline uint32_t numbers_above(const float* lanes, uint32_t x) {
#if KINDLING_SIMD_LEVEL == 512
  return _mm512_cmpgt_epu32_mask(_mm512_load_si512(lanes), _mm512_set1_epi32(static_cast<int>(x)));
#else
  uint32_t bits = 0;
  for (uint32_t i = 0; i < kRayLanes; ++i) bits |= static_cast<uint32_t>(std::bit_cast<uint32_t>(lanes[i]) > x) << i;
  return bits;
#endif
}

struct alignas(64) RayLanes {
  float origin[3][kRayLanes], direction[3][kRayLanes];
  float t_min[kRayLanes], t_max[kRayLanes]; // t_min not below zero

  // `count` rays, 1 to 16, of which ray_at(i) refers to number i; the last is repeated.
  template <class RayAt>
  void load(uint32_t count, const RayAt& ray_at) {
#if KINDLING_SIMD_LEVEL == 512
    // In registers: a wide load would have to wait for narrow stores.
    __m512 o[4], d[4]; // quads of rays i, i + 4, i + 8 and i + 12
    for (uint32_t i = 0; i < 4; ++i) {
      const Ray &r0 = ray_at(std::min(i, count - 1)), &r1 = ray_at(std::min(i + 4, count - 1)),
                &r2 = ray_at(std::min(i + 8, count - 1)), &r3 = ray_at(std::min(i + 12, count - 1));
      o[i] = four_quads(origin_quad(r0), origin_quad(r1), origin_quad(r2), origin_quad(r3));
      d[i] = four_quads(direction_quad(r0), direction_quad(r1), direction_quad(r2), direction_quad(r3));
    }
    transpose(o, {origin[0], origin[1], origin[2], t_min});
    transpose(d, {direction[0], direction[1], direction[2], t_max});
#else
    for (uint32_t i = 0; i < kRayLanes; i += 4) {
      const Ray &a = ray_at(std::min(i, count - 1)), &b = ray_at(std::min(i + 1, count - 1)),
                &c = ray_at(std::min(i + 2, count - 1)), &d = ray_at(std::min(i + 3, count - 1));
      transpose(origin_quad(a), origin_quad(b), origin_quad(c), origin_quad(d),
                {origin[0] + i, origin[1] + i, origin[2] + i, t_min + i});
      transpose(direction_quad(a), direction_quad(b), direction_quad(c), direction_quad(d),
                {direction[0] + i, direction[1] + i, direction[2] + i, t_max + i});
    }
#endif
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
