// Lanes of float or uint32_t for one SIMD target: AVX-512, AVX2 or plain loops, with equal results. Included once for each target,
// with KINDLING_SIMD its namespace and KINDLING_SIMD_LEVEL its level (512, 2 or 0).
//
// All operations are IEEE single operations without contraction. min and max return the second operand if either is NaN.
// Float8 and Int8 have eight lanes, which is what a wide node has; Float16 has sixteen, as many as a leaf block has vertices and a packet
// rays, in one register or two. WideFloat and WideInt have kLanes, as many as the target handles at once: triangles of a leaf.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/includes.h"

namespace kindling::accel::kd::KINDLING_SIMD {

#if KINDLING_SIMD_LEVEL >= 2

struct Float8 {
  __m256 v;
  Float8() = default;
  Float8(__m256 x) : v(x) {}
  explicit Float8(float x) : v(_mm256_set1_ps(x)) {}
  static Float8 load(const float* p) { return _mm256_loadu_ps(p); }
  // {p[0..3], p[0..3]}; p aligned to 16 bytes.
  static Float8 load_twice(const float* p) { return _mm256_broadcast_ps(reinterpret_cast<const __m128*>(p)); }
  void store(float* p) const { _mm256_storeu_ps(p, v); }
};
inline Float8 operator+(Float8 a, Float8 b) { return _mm256_add_ps(a.v, b.v); }
inline Float8 operator-(Float8 a, Float8 b) { return _mm256_sub_ps(a.v, b.v); }
inline Float8 operator*(Float8 a, Float8 b) { return _mm256_mul_ps(a.v, b.v); }
inline Float8 operator/(Float8 a, Float8 b) { return _mm256_div_ps(a.v, b.v); }
inline Float8 min(Float8 a, Float8 b) { return _mm256_min_ps(a.v, b.v); }
inline Float8 max(Float8 a, Float8 b) { return _mm256_max_ps(a.v, b.v); }
// Bit i: sign of lane i.
inline uint32_t sign_bits(Float8 a) { return static_cast<uint32_t>(_mm256_movemask_ps(a.v)); }
struct Int8 {
  __m256i v;
  Int8() = default;
  Int8(__m256i x) : v(x) {}
  explicit Int8(uint32_t x) : v(_mm256_set1_epi32(static_cast<int>(x))) {}
  static Int8 load(const uint32_t* p) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)); }
  // Lane i: byte i.
  static Int8 from_bytes(uint64_t bytes) {
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(bytes)));
  }
  void store(uint32_t* p) const { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), v); }
};
template <int kBits>
inline Int8 shift_right(Int8 a) {
  return _mm256_srli_epi32(a.v, kBits);
}
// Lane i shifted by 2 i.
inline Int8 shift_by_lane(Int8 a) { return _mm256_srlv_epi32(a.v, _mm256_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14)); }
// Lane i: a[low three bits of index[i]].
inline Float8 permute(Float8 a, Int8 index) { return _mm256_permutevar8x32_ps(a.v, index.v); }
inline Int8 permute(Int8 a, Int8 index) { return _mm256_permutevar8x32_epi32(a.v, index.v); }
// Lane kLane of a in all lanes.
template <int kLane>
inline Float8 broadcast_lane(Float8 a) {
  return _mm256_permutevar8x32_ps(a.v, _mm256_set1_epi32(kLane));
}
inline void prefetch(const void* p) { _mm_prefetch(static_cast<const char*>(p), _MM_HINT_T0); }

#endif

#if KINDLING_SIMD_LEVEL == 512

// a; in the lanes of the constant mask max(t, a) or min(t, a), where NaN in t leaves a.
template <int kMask>
inline Float8 max_where(Float8 a, Float8 t) {
  return _mm256_mask_max_ps(a.v, kMask, t.v, a.v);
}
template <int kMask>
inline Float8 min_where(Float8 a, Float8 t) {
  return _mm256_mask_min_ps(a.v, kMask, t.v, a.v);
}
// Comparisons: bit i of the result is lane i.
inline uint32_t at_least(Float8 a, Float8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ); }
inline uint32_t at_most(Float8 a, Float8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
// The low three bits of lane i equal x.
inline uint32_t low_bits_equal(Int8 a, uint32_t x) {
  const __m256i low = _mm256_and_si256(a.v, _mm256_set1_epi32(7));
  return _mm256_cmpeq_epi32_mask(low, _mm256_set1_epi32(static_cast<int>(x)));
}
inline uint32_t nonzero_bits(Int8 a) { return _mm256_test_epi32_mask(a.v, a.v); }

// Moves the lanes of a mask to the front; what stands behind them is undefined.
class Compress8 {
 public:
  explicit Compress8(uint32_t mask) : mask_(static_cast<__mmask8>(mask)) {}
  [[nodiscard]] Float8 operator()(Float8 a) const { return _mm256_maskz_compress_ps(mask_, a.v); }
  [[nodiscard]] Int8 operator()(Int8 a) const { return _mm256_maskz_compress_epi32(mask_, a.v); }

 private:
  __mmask8 mask_;
};

inline constexpr uint32_t kLanes = 16;

struct WideFloat {
  __m512 v;
  WideFloat() = default;
  WideFloat(__m512 x) : v(x) {}
  explicit WideFloat(float x) : v(_mm512_set1_ps(x)) {}
  static WideFloat load(const float* p) { return _mm512_loadu_ps(p); }
  void store(float* p) const { _mm512_storeu_ps(p, v); }
};
inline WideFloat operator+(WideFloat a, WideFloat b) { return _mm512_add_ps(a.v, b.v); }
inline WideFloat operator-(WideFloat a, WideFloat b) { return _mm512_sub_ps(a.v, b.v); }
inline WideFloat operator*(WideFloat a, WideFloat b) { return _mm512_mul_ps(a.v, b.v); }
inline WideFloat operator/(WideFloat a, WideFloat b) { return _mm512_div_ps(a.v, b.v); }
inline WideFloat min(WideFloat a, WideFloat b) { return _mm512_min_ps(a.v, b.v); }
inline WideFloat max(WideFloat a, WideFloat b) { return _mm512_max_ps(a.v, b.v); }
inline uint32_t at_least(WideFloat a, WideFloat b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ); }
inline uint32_t at_most(WideFloat a, WideFloat b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
inline uint32_t above(WideFloat a, WideFloat b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_GT_OQ); }
// False if either is NaN.
inline uint32_t differs(WideFloat a, WideFloat b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_NEQ_OQ); }
// Lanes of b where the bit is set, else of a.
inline WideFloat select(uint32_t mask, WideFloat a, WideFloat b) {
  return _mm512_mask_blend_ps(static_cast<__mmask16>(mask), a.v, b.v);
}
inline WideFloat magnitude(WideFloat a) { return _mm512_abs_ps(a.v); }
inline uint32_t sign_bits(WideFloat a) { return _mm512_movepi32_mask(_mm512_castps_si512(a.v)); }
inline float least(WideFloat a) { return _mm512_reduce_min_ps(a.v); }
inline float greatest(WideFloat a) { return _mm512_reduce_max_ps(a.v); }

struct WideInt {
  __m512i v;
  WideInt() = default;
  WideInt(__m512i x) : v(x) {}
  explicit WideInt(uint32_t x) : v(_mm512_set1_epi32(static_cast<int>(x))) {}
  static WideInt load(const uint32_t* p) { return _mm512_loadu_si512(p); }
  // Lane i: p[i].
  static WideInt load(const uint16_t* p) {
    return _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
  }
  void store(uint32_t* p) const { _mm512_storeu_si512(p, v); }
};
template <int kBits>
inline WideInt shift_right(WideInt a) {
  return _mm512_srli_epi32(a.v, kBits);
}

// Bit i: top bit of lane i.
inline uint32_t top_bits(WideInt a) { return _mm512_movepi32_mask(a.v); }

// As Compress8, for all lanes.
class CompressWide {
 public:
  explicit CompressWide(uint32_t mask) : mask_(static_cast<__mmask16>(mask)) {}
  [[nodiscard]] WideFloat operator()(WideFloat a) const { return _mm512_maskz_compress_ps(mask_, a.v); }
  [[nodiscard]] WideInt operator()(WideInt a) const { return _mm512_maskz_compress_epi32(mask_, a.v); }

 private:
  __mmask16 mask_;
};

using Float16 = WideFloat;
// Lane i: table[low four bits of index[i]].
inline WideFloat pick(Float16 table, WideInt index) { return _mm512_permutexvar_ps(index.v, table.v); }
// Lane i: the bits whose numbers are the low four bits of a[i], b[i] and c[i].
inline WideInt bits_of(WideInt a, WideInt b, WideInt c) {
  const __m512i one = _mm512_set1_epi32(1), low = _mm512_set1_epi32(15);
  return _mm512_or_si512(_mm512_or_si512(_mm512_sllv_epi32(one, _mm512_and_si512(a.v, low)),
                                         _mm512_sllv_epi32(one, _mm512_and_si512(b.v, low))),
                         _mm512_sllv_epi32(one, _mm512_and_si512(c.v, low)));
}
// Bit i: all bits of lane i are in the set.
inline uint32_t subset_of(WideInt bits, uint32_t set) {
  return _mm512_testn_epi32_mask(bits.v, _mm512_set1_epi32(static_cast<int>(~set)));
}

#elif KINDLING_SIMD_LEVEL == 2

template <int kMask>
inline Float8 max_where(Float8 a, Float8 t) {
  return max(Float8(_mm256_blend_ps(a.v, t.v, kMask)), a);
}
template <int kMask>
inline Float8 min_where(Float8 a, Float8 t) {
  return min(Float8(_mm256_blend_ps(a.v, t.v, kMask)), a);
}
inline uint32_t to_bits(__m256 mask) { return static_cast<uint32_t>(_mm256_movemask_ps(mask)); }
inline uint32_t to_bits(__m256i mask) { return to_bits(_mm256_castsi256_ps(mask)); }
inline uint32_t at_least(Float8 a, Float8 b) { return to_bits(_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)); }
inline uint32_t at_most(Float8 a, Float8 b) { return to_bits(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)); }
inline uint32_t above(Float8 a, Float8 b) { return to_bits(_mm256_cmp_ps(a.v, b.v, _CMP_GT_OQ)); }
inline uint32_t differs(Float8 a, Float8 b) { return to_bits(_mm256_cmp_ps(a.v, b.v, _CMP_NEQ_OQ)); }
inline uint32_t low_bits_equal(Int8 a, uint32_t x) {
  const __m256i low = _mm256_and_si256(a.v, _mm256_set1_epi32(7));
  return to_bits(_mm256_cmpeq_epi32(low, _mm256_set1_epi32(static_cast<int>(x))));
}
inline uint32_t nonzero_bits(Int8 a) { return ~to_bits(_mm256_cmpeq_epi32(a.v, _mm256_setzero_si256())) & 0xffU; }

class Compress8 {
 public:
  explicit Compress8(uint32_t mask) : index_(Int8::from_bytes(tables::kCompress[mask])) {}
  [[nodiscard]] Float8 operator()(Float8 a) const { return permute(a, index_); }
  [[nodiscard]] Int8 operator()(Int8 a) const { return permute(a, index_); }

 private:
  Int8 index_;
};

inline constexpr uint32_t kLanes = 8;
using WideFloat = Float8;
// All bits of lane i: bit i.
inline __m256i lanes_of(uint32_t mask) {
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask)), bit), bit);
}
inline WideFloat select(uint32_t mask, WideFloat a, WideFloat b) {
  return _mm256_blendv_ps(a.v, b.v, _mm256_castsi256_ps(lanes_of(mask)));
}

struct WideInt : Int8 {
  using Int8::Int8;
  WideInt(Int8 x) : Int8(x) {}
  static WideInt load(const uint32_t* p) { return Int8::load(p); }
  static WideInt load(const uint16_t* p) {
    return WideInt(_mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
  }
};
template <int kBits>
inline WideInt shift_right(WideInt a) {
  return WideInt(_mm256_srli_epi32(a.v, kBits));
}

inline uint32_t top_bits(WideInt a) { return to_bits(a.v); }

class CompressWide {
 public:
  explicit CompressWide(uint32_t mask) : compress_(mask) {}
  [[nodiscard]] WideFloat operator()(WideFloat a) const { return compress_(a); }
  [[nodiscard]] WideInt operator()(WideInt a) const { return compress_(static_cast<const Int8&>(a)); }

 private:
  Compress8 compress_;
};

struct Float16 {
  Float8 low, high;
  Float16() = default;
  Float16(Float8 l, Float8 h) : low(l), high(h) {}
  explicit Float16(float x) : low(x), high(x) {}
  static Float16 load(const float* p) { return {Float8::load(p), Float8::load(p + 8)}; }
  void store(float* p) const {
    low.store(p);
    high.store(p + 8);
  }
};
inline Float16 operator+(const Float16& a, const Float16& b) { return {a.low + b.low, a.high + b.high}; }
inline Float16 operator-(const Float16& a, const Float16& b) { return {a.low - b.low, a.high - b.high}; }
inline Float16 operator*(const Float16& a, const Float16& b) { return {a.low * b.low, a.high * b.high}; }
inline Float16 operator/(const Float16& a, const Float16& b) { return {a.low / b.low, a.high / b.high}; }
inline Float16 min(const Float16& a, const Float16& b) { return {min(a.low, b.low), min(a.high, b.high)}; }
inline Float16 max(const Float16& a, const Float16& b) { return {max(a.low, b.low), max(a.high, b.high)}; }
inline uint32_t at_least(const Float16& a, const Float16& b) {
  return at_least(a.low, b.low) | at_least(a.high, b.high) << 8;
}
inline uint32_t at_most(const Float16& a, const Float16& b) {
  return at_most(a.low, b.low) | at_most(a.high, b.high) << 8;
}
inline uint32_t above(const Float16& a, const Float16& b) { return above(a.low, b.low) | above(a.high, b.high) << 8; }
inline uint32_t differs(const Float16& a, const Float16& b) {
  return differs(a.low, b.low) | differs(a.high, b.high) << 8;
}
inline Float16 select(uint32_t mask, const Float16& a, const Float16& b) {
  return {select(mask, a.low, b.low), select(mask >> 8, a.high, b.high)};
}
inline Float16 magnitude(const Float16& a) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {_mm256_andnot_ps(sign, a.low.v), _mm256_andnot_ps(sign, a.high.v)};
}
inline uint32_t sign_bits(const Float16& a) { return sign_bits(a.low) | sign_bits(a.high) << 8; }
inline float least(const Float16& a) {
  const Float8 half = min(a.low, a.high);
  const __m128 quarter = _mm_min_ps(_mm256_castps256_ps128(half.v), _mm256_extractf128_ps(half.v, 1));
  const __m128 pair = _mm_min_ps(quarter, _mm_movehl_ps(quarter, quarter));
  return _mm_cvtss_f32(_mm_min_ss(pair, _mm_movehdup_ps(pair)));
}
inline float greatest(const Float16& a) {
  const Float8 half = max(a.low, a.high);
  const __m128 quarter = _mm_max_ps(_mm256_castps256_ps128(half.v), _mm256_extractf128_ps(half.v, 1));
  const __m128 pair = _mm_max_ps(quarter, _mm_movehl_ps(quarter, quarter));
  return _mm_cvtss_f32(_mm_max_ss(pair, _mm_movehdup_ps(pair)));
}
inline WideFloat pick(const Float16& table, WideInt index) {
  return _mm256_blendv_ps(permute(table.low, index).v, permute(table.high, index).v,
                          _mm256_castsi256_ps(_mm256_slli_epi32(index.v, 28)));
}
inline WideInt bits_of(WideInt a, WideInt b, WideInt c) {
  const __m256i one = _mm256_set1_epi32(1), low = _mm256_set1_epi32(15);
  return WideInt(_mm256_or_si256(_mm256_or_si256(_mm256_sllv_epi32(one, _mm256_and_si256(a.v, low)),
                                                 _mm256_sllv_epi32(one, _mm256_and_si256(b.v, low))),
                                 _mm256_sllv_epi32(one, _mm256_and_si256(c.v, low))));
}
inline uint32_t subset_of(WideInt bits, uint32_t set) {
  const __m256i outside = _mm256_and_si256(bits.v, _mm256_set1_epi32(static_cast<int>(~set)));
  return to_bits(_mm256_cmpeq_epi32(outside, _mm256_setzero_si256()));
}

#else

template <class T, uint32_t N>
struct alignas(sizeof(T) * N) Lanes {
  std::array<T, N> v;
  Lanes() = default;
  explicit Lanes(T x) { v.fill(x); }
  template <class S>
  static Lanes load(const S* p) {
    Lanes r;
    for (uint32_t i = 0; i < N; ++i) r.v[i] = p[i];
    return r;
  }
  static Lanes load_twice(const T* p) {
    Lanes r;
    for (uint32_t i = 0; i < N; ++i) r.v[i] = p[i % (N / 2)];
    return r;
  }
  static Lanes from_bytes(uint64_t bytes) {
    Lanes r;
    for (uint32_t i = 0; i < N; ++i) r.v[i] = static_cast<T>((bytes >> (8 * i)) & 0xffU);
    return r;
  }
  void store(T* p) const { std::memcpy(p, v.data(), sizeof(v)); }
};
using Float8 = Lanes<float, 8>;
using Int8 = Lanes<uint32_t, 8>;

template <class T, uint32_t N, class F>
inline Lanes<T, N> combine(const Lanes<T, N>& a, const Lanes<T, N>& b, F f) {
  Lanes<T, N> r;
  for (uint32_t i = 0; i < N; ++i) r.v[i] = f(a.v[i], b.v[i]);
  return r;
}
template <class T, uint32_t N, class F>
inline uint32_t compare(const Lanes<T, N>& a, const Lanes<T, N>& b, F f) {
  uint32_t r = 0;
  for (uint32_t i = 0; i < N; ++i) r |= static_cast<uint32_t>(f(a.v[i], b.v[i])) << i;
  return r;
}
template <uint32_t N>
inline Lanes<float, N> operator+(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x + y; });
}
template <uint32_t N>
inline Lanes<float, N> operator-(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x - y; });
}
template <uint32_t N>
inline Lanes<float, N> operator*(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x * y; });
}
template <uint32_t N>
inline Lanes<float, N> operator/(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x / y; });
}
template <uint32_t N>
inline Lanes<float, N> min(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x < y ? x : y; });
}
template <uint32_t N>
inline Lanes<float, N> max(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x > y ? x : y; });
}
template <uint32_t N>
inline uint32_t at_least(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return compare(a, b, [](float x, float y) { return x >= y; });
}
template <uint32_t N>
inline uint32_t at_most(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return compare(a, b, [](float x, float y) { return x <= y; });
}
template <uint32_t N>
inline uint32_t above(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return compare(a, b, [](float x, float y) { return x > y; });
}
template <uint32_t N>
inline uint32_t differs(const Lanes<float, N>& a, const Lanes<float, N>& b) {
  return compare(a, b, [](float x, float y) { return x < y || x > y; });
}
template <uint32_t N>
inline uint32_t sign_bits(const Lanes<float, N>& a) {
  return compare(a, a, [](float x, float) { return std::bit_cast<uint32_t>(x) >> 31; });
}
inline uint32_t low_bits_equal(const Int8& a, uint32_t x) {
  return compare(a, Int8(x), [](uint32_t y, uint32_t z) { return (y & 7) == z; });
}
inline uint32_t nonzero_bits(const Int8& a) {
  return compare(a, a, [](uint32_t x, uint32_t) { return x != 0; });
}
template <class T, uint32_t N>
inline Lanes<T, N> select(uint32_t mask, const Lanes<T, N>& a, const Lanes<T, N>& b) {
  Lanes<T, N> r;
  for (uint32_t i = 0; i < N; ++i) r.v[i] = ((mask >> i) & 1U) != 0 ? b.v[i] : a.v[i];
  return r;
}
template <int kMask>
inline Float8 max_where(const Float8& a, const Float8& t) {
  return max(select(kMask, a, t), a);
}
template <int kMask>
inline Float8 min_where(const Float8& a, const Float8& t) {
  return min(select(kMask, a, t), a);
}
template <int kBits>
inline Int8 shift_right(Int8 a) {
  for (uint32_t& x : a.v) x >>= kBits;
  return a;
}
inline Int8 shift_by_lane(Int8 a) {
  for (uint32_t i = 0; i < 8; ++i) a.v[i] >>= 2 * i;
  return a;
}
template <class T>
inline Lanes<T, 8> permute(const Lanes<T, 8>& a, const Int8& index) {
  Lanes<T, 8> r;
  for (uint32_t i = 0; i < 8; ++i) r.v[i] = a.v[index.v[i] & 7];
  return r;
}
template <int kLane>
inline Float8 broadcast_lane(const Float8& a) {
  return Float8(a.v[kLane]);
}
inline void prefetch(const void* p) { __builtin_prefetch(p); }

class Compress8 {
 public:
  explicit Compress8(uint32_t mask) : index_(Int8::from_bytes(tables::kCompress[mask])) {}
  template <class T>
  [[nodiscard]] Lanes<T, 8> operator()(const Lanes<T, 8>& a) const {
    return permute(a, index_);
  }

 private:
  Int8 index_;
};

inline constexpr uint32_t kLanes = 8;
using WideFloat = Float8;
using WideInt = Int8;
inline uint32_t top_bits(const WideInt& a) {
  return compare(a, a, [](uint32_t x, uint32_t) { return x >> 31; });
}
using CompressWide = Compress8;
using Float16 = Lanes<float, 16>;
inline WideFloat pick(const Float16& table, const WideInt& index) {
  WideFloat r;
  for (uint32_t i = 0; i < kLanes; ++i) r.v[i] = table.v[index.v[i] & 15];
  return r;
}
inline Float16 magnitude(Float16 a) {
  for (float& x : a.v) x = std::fabs(x);
  return a;
}
inline float least(const Float16& a) { return *std::min_element(a.v.begin(), a.v.end()); }
inline float greatest(const Float16& a) { return *std::max_element(a.v.begin(), a.v.end()); }
inline WideInt bits_of(const WideInt& a, const WideInt& b, const WideInt& c) {
  WideInt r;
  for (uint32_t i = 0; i < kLanes; ++i) r.v[i] = 1U << (a.v[i] & 15) | 1U << (b.v[i] & 15) | 1U << (c.v[i] & 15);
  return r;
}
inline uint32_t subset_of(const WideInt& bits, uint32_t set) {
  return compare(bits, WideInt(~set), [](uint32_t x, uint32_t y) { return (x & y) == 0; });
}

#endif

} // namespace kindling::accel::kd::KINDLING_SIMD
