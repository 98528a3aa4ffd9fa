// SIMD vectors of eight floats: operations of the light tree beyond those of compiler vector types.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/simd_types.h"

#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace kindling {

// Every operation gives the bits of IEEE 754 in each lane, with vector instructions and without.

[[nodiscard]] inline Float8 splat(float x) { return Float8{x, x, x, x, x, x, x, x}; }
[[nodiscard]] inline Float8 larger(const Float8& a, const Float8& b) { return a > b ? a : b; }
[[nodiscard]] inline Float8 smaller(const Float8& a, const Float8& b) { return a < b ? a : b; }

[[nodiscard]] inline Float8 to_float(const uint8_t (&bytes)[8]) {
#ifdef __AVX2__
  const __m128i packed = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(bytes));
  return static_cast<Float8>(_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(packed)));
#else
  Float8 result;
  for (int i = 0; i < 8; ++i) result[i] = static_cast<float>(bytes[i]);
  return result;
#endif
}

[[nodiscard]] inline Float8 to_float(const int8_t (&bytes)[8]) {
#ifdef __AVX2__
  const __m128i packed = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(bytes));
  return static_cast<Float8>(_mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(packed)));
#else
  Float8 result;
  for (int i = 0; i < 8; ++i) result[i] = static_cast<float>(bytes[i]);
  return result;
#endif
}

// Returns floats from the upper sixteen bits below the sign bit; the other bits and the sign are 0.
[[nodiscard]] inline Float8 from_upper_bits(const uint16_t (&bits)[8]) {
#ifdef __AVX2__
  const __m128i packed = _mm_load_si128(reinterpret_cast<const __m128i*>(bits));
  return static_cast<Float8>(_mm256_castsi256_ps(_mm256_slli_epi32(_mm256_cvtepu16_epi32(packed), 15)));
#else
  Float8 result;
  for (int i = 0; i < 8; ++i) result[i] = std::bit_cast<float>(static_cast<uint32_t>(bits[i]) << 15);
  return result;
#endif
}

[[nodiscard]] inline Float8 square_root(const Float8& x) {
#ifdef __AVX2__
  return static_cast<Float8>(_mm256_sqrt_ps(static_cast<__m256>(x)));
#else
  Float8 result;
  for (int i = 0; i < 8; ++i) result[i] = std::sqrt(x[i]);
  return result;
#endif
}

[[nodiscard]] inline Float8 absolute(const Float8& x) {
  return reinterpret_cast<Float8>(reinterpret_cast<Int8>(x) & 0x7fffffff);
}
// Returns x in lanes where the mask is set, else 0.
[[nodiscard]] inline Float8 where(const Int8& mask, const Float8& x) {
  return reinterpret_cast<Float8>(mask & reinterpret_cast<Int8>(x));
}

// Returns the inclusive prefix sums of the lanes; the last is the total. Three steps, always in the
// same order.
[[nodiscard]] inline Float8 running_sums(Float8 v) {
#ifdef __AVX2__
  const auto shifted = [](const Float8& x, auto bytes) {
    return static_cast<Float8>(
        _mm256_castsi256_ps(_mm256_slli_si256(_mm256_castps_si256(static_cast<__m256>(x)), decltype(bytes)::value)));
  };
  v += shifted(v, std::integral_constant<int, 4>());
  v += shifted(v, std::integral_constant<int, 8>());
  const __m256 last = _mm256_permute_ps(static_cast<__m256>(v), 0xff);
  v += static_cast<Float8>(_mm256_permute2f128_ps(last, last, 0x08)); // adds the lower half's sum to the upper half
#else
  const Float8 zero{};
  v += __builtin_shufflevector(v, zero, 8, 0, 1, 2, 8, 4, 5, 6);
  v += __builtin_shufflevector(v, zero, 8, 8, 0, 1, 8, 8, 4, 5);
  v += __builtin_shufflevector(v, zero, 8, 8, 8, 8, 3, 3, 3, 3);
#endif
  return v;
}

// Returns the sum of the lanes before `lane`, given running_sums(). Branch-free.
[[nodiscard]] inline float sums_before(const Float8& sums, uint32_t lane) {
  assert(lane <= 8);
  float values[9];
  values[0] = 0.0f;
  std::memcpy(values + 1, &sums, sizeof(sums));
  return values[lane];
}

// Returns the number of lanes that do not exceed x.
[[nodiscard]] inline uint32_t count_up_to(const Float8& lanes, float x) {
#ifdef __AVX2__
  const __m256 below = _mm256_cmp_ps(static_cast<__m256>(lanes), _mm256_set1_ps(x), _CMP_LE_OQ);
  return static_cast<uint32_t>(std::popcount(static_cast<uint32_t>(_mm256_movemask_ps(below))));
#else
  uint32_t count = 0;
  for (int i = 0; i < 8; ++i) count += lanes[i] <= x ? 1 : 0;
  return count;
#endif
}

} // namespace kindling
