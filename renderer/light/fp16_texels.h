// Texels of four halves and their bilinear interpolation, with F16C instructions where available.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/half_float.h"
#include "renderer/base/math.h"

#include <half.h>

#include <cstdint>

#ifdef __F16C__
#include <immintrin.h>
#endif

namespace kindling {

// Bits of IEEE 754 binary16.
struct alignas(8) Fp16Texel {
  uint16_t r = 0;
  uint16_t g = 0;
  uint16_t b = 0;
  uint16_t weight = 0; // of the sampling density; interpolated like the color
};
static_assert(sizeof(Fp16Texel) == 8);

// Rounds to nearest, ties to even.
[[nodiscard]] inline uint16_t float_to_half(float value) { return imath_float_to_half(value); }

// Returns R, G, B and weight interpolated between the pairs upper[0], upper[1] and lower[0],
// lower[1]; fx and fy in [0, 1]. Both variants below perform the same operations in the same order,
// so they give the same bits.
[[nodiscard]] inline V4f interpolate(const Fp16Texel* upper, const Fp16Texel* lower, float fx, float fy) {
#ifdef __F16C__
  const __m256 a = _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(upper)));
  const __m256 b = _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(lower)));
  const __m256 column = _mm256_add_ps(a, _mm256_mul_ps(_mm256_sub_ps(b, a), _mm256_set1_ps(fy)));
  const __m128 left = _mm256_castps256_ps128(column);
  const __m128 right = _mm256_extractf128_ps(column, 1);
  const __m128 result = _mm_add_ps(left, _mm_mul_ps(_mm_sub_ps(right, left), _mm_set1_ps(fx)));
  alignas(16) float value[4];
  _mm_store_ps(value, result);
  return {value[0], value[1], value[2], value[3]};
#else
  const auto value = [](const Fp16Texel& t) {
    return V4f(half_to_float(t.r), half_to_float(t.g), half_to_float(t.b), half_to_float(t.weight));
  };
  const auto mix = [](const V4f& x, const V4f& y, float t) { return x + (y - x) * t; };
  return mix(mix(value(upper[0]), value(lower[0]), fy), mix(value(upper[1]), value(lower[1]), fy), fx);
#endif
}

} // namespace kindling
