// Eight and four floats at a time: vectors of the compiler, with AVX or SSE where it has them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#ifdef __SSE__
#include <immintrin.h>
#endif

namespace compressed_bvh {

using Float8 [[gnu::vector_size(32)]] = float;
using Int8 [[gnu::vector_size(32)]] = int32_t;
using Float4 [[gnu::vector_size(16)]] = float;
using Int4 [[gnu::vector_size(16)]] = int32_t;
using Double4 [[gnu::vector_size(32)]] = double;

// The second one where the first is NaN.
inline Float8 max(const Float8& a, const Float8& b) {
#ifdef __AVX__
  return reinterpret_cast<Float8>(_mm256_max_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b)));
#else
  return a > b ? a : b;
#endif
}
inline Float8 min(const Float8& a, const Float8& b) {
#ifdef __AVX__
  return reinterpret_cast<Float8>(_mm256_min_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b)));
#else
  return a < b ? a : b;
#endif
}

// A bit for each lane whose mask is set.
inline unsigned bits_of(const Int8& mask) {
#ifdef __AVX__
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#else
  unsigned bits = 0;
  for (int lane = 0; lane < 8; ++lane) bits |= (mask[lane] != 0 ? 1U : 0U) << lane;
  return bits;
#endif
}
inline unsigned bits_of(const Int4& mask) {
#ifdef __SSE__
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#else
  unsigned bits = 0;
  for (int lane = 0; lane < 4; ++lane) bits |= (mask[lane] != 0 ? 1U : 0U) << lane;
  return bits;
#endif
}

// Eight bytes as floats.
inline Float8 load_bytes(const uint8_t* bytes) {
#ifdef __AVX2__
  return reinterpret_cast<Float8>(
      _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(bytes)))));
#else
  Float8 floats;
  for (int lane = 0; lane < 8; ++lane) floats[lane] = static_cast<float>(bytes[lane]);
  return floats;
#endif
}

inline Float4 load(const float* four) {
  Float4 lanes;
  std::memcpy(&lanes, four, sizeof lanes);
  return lanes;
}
inline Float4 all4(float value) { return Float4{} + value; }
inline Float8 all8(float value) { return Float8{} + value; }

} // namespace compressed_bvh
