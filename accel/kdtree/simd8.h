// Eight lanes of float or uint32_t: AVX2 where the compiler targets it, plain loops elsewhere, with equal results.
//
// All operations are IEEE single operations without contraction. min and max return the second operand if either is NaN.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace kindling::accel::kd {

#if defined(__AVX2__)

struct Float8 {
  __m256 v;
  Float8() = default;
  Float8(__m256 x) : v(x) {}
  explicit Float8(float x) : v(_mm256_set1_ps(x)) {}
  static Float8 load(const float* p) { return _mm256_load_ps(p); }
  // {p[0..3], p[0..3]}; p aligned to 16 bytes.
  static Float8 load_twice(const float* p) { return _mm256_broadcast_ps(reinterpret_cast<const __m128*>(p)); }
  void store(float* p) const { _mm256_store_ps(p, v); }
  void store_unaligned(float* p) const { _mm256_storeu_ps(p, v); }
};
inline Float8 operator+(Float8 a, Float8 b) { return _mm256_add_ps(a.v, b.v); }
inline Float8 operator-(Float8 a, Float8 b) { return _mm256_sub_ps(a.v, b.v); }
inline Float8 operator*(Float8 a, Float8 b) { return _mm256_mul_ps(a.v, b.v); }
inline Float8 operator/(Float8 a, Float8 b) { return _mm256_div_ps(a.v, b.v); }
inline Float8 min(Float8 a, Float8 b) { return _mm256_min_ps(a.v, b.v); }
inline Float8 max(Float8 a, Float8 b) { return _mm256_max_ps(a.v, b.v); }

struct Mask8 {
  __m256 v;
  // Bit i: lane i.
  [[nodiscard]] uint32_t bits() const { return static_cast<uint32_t>(_mm256_movemask_ps(v)); }
};
inline Mask8 operator&(Mask8 a, Mask8 b) { return {_mm256_and_ps(a.v, b.v)}; }
inline Mask8 operator|(Mask8 a, Mask8 b) { return {_mm256_or_ps(a.v, b.v)}; }
inline Mask8 operator>=(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)}; }
inline Mask8 operator<=(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)}; }
inline Mask8 operator>(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GT_OQ)}; }
// False if either is NaN.
inline Mask8 differs(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_NEQ_OQ)}; }
// Bit i: sign of lane i.
inline uint32_t sign_bits(Float8 a) { return static_cast<uint32_t>(_mm256_movemask_ps(a.v)); }
// Lanes of b where the bit of the constant mask is set, else of a.
template <int kMask>
inline Float8 blend(Float8 a, Float8 b) {
  return _mm256_blend_ps(a.v, b.v, kMask);
}

struct Int8 {
  __m256i v;
  Int8() = default;
  Int8(__m256i x) : v(x) {}
  explicit Int8(uint32_t x) : v(_mm256_set1_epi32(static_cast<int>(x))) {}
  static Int8 load(const uint32_t* p) { return _mm256_load_si256(reinterpret_cast<const __m256i*>(p)); }
  // Lane i: byte i.
  static Int8 from_bytes(uint64_t bytes) {
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(bytes)));
  }
  void store_unaligned(uint32_t* p) const { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), v); }
};
template <int kBits>
inline Int8 shift_right(Int8 a) {
  return _mm256_srli_epi32(a.v, kBits);
}
// Lane i shifted by 2 i.
inline Int8 shift_by_lane(Int8 a) { return _mm256_srlv_epi32(a.v, _mm256_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14)); }
// Bit i: the low three bits of lane i equal x.
inline uint32_t low_bits_equal(Int8 a, uint32_t x) {
  const __m256i low = _mm256_and_si256(a.v, _mm256_set1_epi32(7));
  return static_cast<uint32_t>(
      _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(low, _mm256_set1_epi32(static_cast<int>(x))))));
}
// Bit i: top bit of lane i.
inline uint32_t sign_bits(Int8 a) { return static_cast<uint32_t>(_mm256_movemask_ps(_mm256_castsi256_ps(a.v))); }
// Bit i: lane i is not zero.
inline uint32_t nonzero_bits(Int8 a) {
  return ~static_cast<uint32_t>(
             _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a.v, _mm256_setzero_si256())))) &
         0xffU;
}
// Lane i: a[low three bits of index[i]].
inline Float8 permute(Float8 a, Int8 index) { return _mm256_permutevar8x32_ps(a.v, index.v); }
inline Int8 permute(Int8 a, Int8 index) { return _mm256_permutevar8x32_epi32(a.v, index.v); }
// Lane kLane of a in all lanes.
template <int kLane>
inline Float8 broadcast_lane(Float8 a) {
  return _mm256_permutevar8x32_ps(a.v, _mm256_set1_epi32(kLane));
}

inline void prefetch(const void* p) { _mm_prefetch(static_cast<const char*>(p), _MM_HINT_T0); }

#else

struct alignas(32) Float8 {
  std::array<float, 8> v;
  Float8() = default;
  explicit Float8(float x) { v.fill(x); }
  static Float8 load(const float* p) {
    Float8 r;
    std::memcpy(r.v.data(), p, sizeof(r.v));
    return r;
  }
  static Float8 load_twice(const float* p) {
    Float8 r;
    for (size_t i = 0; i < 8; ++i) r.v[i] = p[i & 3];
    return r;
  }
  void store(float* p) const { std::memcpy(p, v.data(), sizeof(v)); }
  void store_unaligned(float* p) const { store(p); }
};
struct Mask8 {
  uint32_t m;
  [[nodiscard]] uint32_t bits() const { return m; }
};
struct alignas(32) Int8 {
  std::array<uint32_t, 8> v;
  Int8() = default;
  explicit Int8(uint32_t x) { v.fill(x); }
  static Int8 load(const uint32_t* p) {
    Int8 r;
    std::memcpy(r.v.data(), p, sizeof(r.v));
    return r;
  }
  static Int8 from_bytes(uint64_t bytes) {
    Int8 r;
    for (size_t i = 0; i < 8; ++i) r.v[i] = static_cast<uint32_t>(bytes >> (8 * i)) & 0xffU;
    return r;
  }
  void store_unaligned(uint32_t* p) const { std::memcpy(p, v.data(), sizeof(v)); }
};
template <class F>
inline Float8 map8(F f) {
  Float8 r;
  for (size_t i = 0; i < 8; ++i) r.v[i] = f(i);
  return r;
}
template <class F>
inline uint32_t bits8(F f) {
  uint32_t r = 0;
  for (size_t i = 0; i < 8; ++i) r |= static_cast<uint32_t>(f(i)) << i;
  return r;
}
inline Float8 operator+(const Float8& a, const Float8& b) {
  return map8([&](size_t i) { return a.v[i] + b.v[i]; });
}
inline Float8 operator-(const Float8& a, const Float8& b) {
  return map8([&](size_t i) { return a.v[i] - b.v[i]; });
}
inline Float8 operator*(const Float8& a, const Float8& b) {
  return map8([&](size_t i) { return a.v[i] * b.v[i]; });
}
inline Float8 operator/(const Float8& a, const Float8& b) {
  return map8([&](size_t i) { return a.v[i] / b.v[i]; });
}
inline Float8 min(const Float8& a, const Float8& b) {
  return map8([&](size_t i) { return a.v[i] < b.v[i] ? a.v[i] : b.v[i]; });
}
inline Float8 max(const Float8& a, const Float8& b) {
  return map8([&](size_t i) { return a.v[i] > b.v[i] ? a.v[i] : b.v[i]; });
}
inline Mask8 operator&(Mask8 a, Mask8 b) { return {a.m & b.m}; }
inline Mask8 operator|(Mask8 a, Mask8 b) { return {a.m | b.m}; }
inline Mask8 operator>=(const Float8& a, const Float8& b) {
  return {bits8([&](size_t i) { return a.v[i] >= b.v[i]; })};
}
inline Mask8 operator<=(const Float8& a, const Float8& b) {
  return {bits8([&](size_t i) { return a.v[i] <= b.v[i]; })};
}
inline Mask8 operator>(const Float8& a, const Float8& b) {
  return {bits8([&](size_t i) { return a.v[i] > b.v[i]; })};
}
inline Mask8 differs(const Float8& a, const Float8& b) {
  return {bits8([&](size_t i) { return a.v[i] < b.v[i] || a.v[i] > b.v[i]; })};
}
inline uint32_t sign_bits(const Float8& a) {
  return bits8([&](size_t i) { return std::bit_cast<uint32_t>(a.v[i]) >> 31; });
}
template <int kMask>
inline Float8 blend(const Float8& a, const Float8& b) {
  return map8([&](size_t i) { return ((kMask >> i) & 1) != 0 ? b.v[i] : a.v[i]; });
}
template <int kBits>
inline Int8 shift_right(Int8 a) {
  for (uint32_t& x : a.v) x >>= kBits;
  return a;
}
inline Int8 shift_by_lane(Int8 a) {
  for (size_t i = 0; i < 8; ++i) a.v[i] >>= 2 * i;
  return a;
}
inline uint32_t low_bits_equal(const Int8& a, uint32_t x) {
  return bits8([&](size_t i) { return (a.v[i] & 7) == x; });
}
inline uint32_t sign_bits(const Int8& a) {
  return bits8([&](size_t i) { return a.v[i] >> 31; });
}
inline uint32_t nonzero_bits(const Int8& a) {
  return bits8([&](size_t i) { return a.v[i] != 0; });
}
inline Float8 permute(const Float8& a, const Int8& index) {
  return map8([&](size_t i) { return a.v[index.v[i] & 7]; });
}
inline Int8 permute(const Int8& a, const Int8& index) {
  Int8 r;
  for (size_t i = 0; i < 8; ++i) r.v[i] = a.v[index.v[i] & 7];
  return r;
}
template <int kLane>
inline Float8 broadcast_lane(const Float8& a) {
  return Float8(a.v[kLane]);
}
inline void prefetch(const void* p) { __builtin_prefetch(p); }

#endif

} // namespace kindling::accel::kd
