// SIMD lanes in intrinsics: AVX2, and AVX-512 (F, VL, BW, DQ). See simd.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/includes.h"

namespace kindling::accel::kd::KINDLING_SIMD {

struct Lanes8 {
  __m256 v;
  Lanes8() = default;
  Lanes8(__m256 x) : v(x) {}
  explicit Lanes8(float x) : v(_mm256_set1_ps(x)) {}
  static Lanes8 load(const float* p) { return _mm256_loadu_ps(p); }
  // {p[0..3], p[0..3]}; p aligned to 16 bytes.
  static Lanes8 load_twice(const float* p) { return _mm256_broadcast_ps(reinterpret_cast<const __m128*>(p)); }
  void store(float* p) const { _mm256_storeu_ps(p, v); }
};
inline Lanes8 operator+(Lanes8 a, Lanes8 b) { return _mm256_add_ps(a.v, b.v); }
inline Lanes8 operator-(Lanes8 a, Lanes8 b) { return _mm256_sub_ps(a.v, b.v); }
inline Lanes8 operator*(Lanes8 a, Lanes8 b) { return _mm256_mul_ps(a.v, b.v); }
inline Lanes8 operator/(Lanes8 a, Lanes8 b) { return _mm256_div_ps(a.v, b.v); }
inline Lanes8 min(Lanes8 a, Lanes8 b) { return _mm256_min_ps(a.v, b.v); }
inline Lanes8 max(Lanes8 a, Lanes8 b) { return _mm256_max_ps(a.v, b.v); }
// Bit i is the sign of lane i.
inline uint32_t sign_bits(Lanes8 a) { return static_cast<uint32_t>(_mm256_movemask_ps(a.v)); }
struct IntLanes8 {
  __m256i v;
  IntLanes8() = default;
  IntLanes8(__m256i x) : v(x) {}
  explicit IntLanes8(uint32_t x) : v(_mm256_set1_epi32(static_cast<int>(x))) {}
  static IntLanes8 load(const uint32_t* p) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)); }
  // Lane i is byte i.
  static IntLanes8 from_bytes(uint64_t bytes) {
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(bytes)));
  }
  void store(uint32_t* p) const { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), v); }
};
// Shifts lane i right by 4 i bits.
inline IntLanes8 shift_by_nibbles(IntLanes8 a) {
  return _mm256_srlv_epi32(a.v, _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
}
// Lane i of the result is a[low three bits of index[i]].
inline Lanes8 permute(Lanes8 a, IntLanes8 index) { return _mm256_permutevar8x32_ps(a.v, index.v); }
inline IntLanes8 permute(IntLanes8 a, IntLanes8 index) { return _mm256_permutevar8x32_epi32(a.v, index.v); }
inline void prefetch(const void* p) { _mm_prefetch(static_cast<const char*>(p), _MM_HINT_T0); }

#if KINDLING_SIMD_LEVEL == 512

// Comparisons return a mask; bit i is lane i.
inline uint32_t at_least(Lanes8 a, Lanes8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ); }
inline uint32_t at_most(Lanes8 a, Lanes8 b) { return _mm256_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
// Bit i is the top bit of lane i.
inline uint32_t top_bits(IntLanes8 a) { return _mm256_movepi32_mask(a.v); }

// Moves the lanes of a mask to the front; the lanes after them are undefined.
class Compress8 {
 public:
  explicit Compress8(uint32_t mask) : mask_(static_cast<__mmask8>(mask)) {}
  [[nodiscard]] Lanes8 operator()(Lanes8 a) const { return _mm256_maskz_compress_ps(mask_, a.v); }
  [[nodiscard]] IntLanes8 operator()(IntLanes8 a) const { return _mm256_maskz_compress_epi32(mask_, a.v); }

 private:
  __mmask8 mask_;
};

inline constexpr uint32_t kLanes = 16;

struct WideLanes {
  __m512 v;
  WideLanes() = default;
  WideLanes(__m512 x) : v(x) {}
  explicit WideLanes(float x) : v(_mm512_set1_ps(x)) {}
  static WideLanes load(const float* p) { return _mm512_loadu_ps(p); }
  void store(float* p) const { _mm512_storeu_ps(p, v); }
};
inline WideLanes operator+(WideLanes a, WideLanes b) { return _mm512_add_ps(a.v, b.v); }
inline WideLanes operator-(WideLanes a, WideLanes b) { return _mm512_sub_ps(a.v, b.v); }
inline WideLanes operator*(WideLanes a, WideLanes b) { return _mm512_mul_ps(a.v, b.v); }
inline WideLanes operator/(WideLanes a, WideLanes b) { return _mm512_div_ps(a.v, b.v); }
inline WideLanes min(WideLanes a, WideLanes b) { return _mm512_min_ps(a.v, b.v); }
inline WideLanes max(WideLanes a, WideLanes b) { return _mm512_max_ps(a.v, b.v); }
inline uint32_t at_least(WideLanes a, WideLanes b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ); }
inline uint32_t at_most(WideLanes a, WideLanes b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
inline uint32_t above(WideLanes a, WideLanes b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_GT_OQ); }
// Clears bit i if either lane is NaN.
inline uint32_t differs(WideLanes a, WideLanes b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_NEQ_OQ); }
// Selects lanes of b where the bit is set, else of a.
inline WideLanes select(uint32_t mask, WideLanes a, WideLanes b) {
  return _mm512_mask_blend_ps(static_cast<__mmask16>(mask), a.v, b.v);
}
inline WideLanes magnitude(WideLanes a) { return _mm512_abs_ps(a.v); }
// See accel/triangle.h.
inline WideLanes difference_of_products(WideLanes a, WideLanes b, WideLanes c, WideLanes d) {
  const WideLanes product = c * d, error = _mm512_fnmadd_ps(c.v, d.v, product.v);
  return WideLanes(_mm512_fmsub_ps(a.v, b.v, product.v)) + error;
}
inline uint32_t sign_bits(WideLanes a) { return _mm512_movepi32_mask(_mm512_castps_si512(a.v)); }
inline float min_lane(WideLanes a) { return _mm512_reduce_min_ps(a.v); }
inline float max_lane(WideLanes a) { return _mm512_reduce_max_ps(a.v); }

struct WideIntLanes {
  __m512i v;
  WideIntLanes() = default;
  WideIntLanes(__m512i x) : v(x) {}
  explicit WideIntLanes(uint32_t x) : v(_mm512_set1_epi32(static_cast<int>(x))) {}
  static WideIntLanes load(const uint32_t* p) { return _mm512_loadu_si512(p); }
  // Lane i is p[i].
  static WideIntLanes load(const uint16_t* p) {
    return _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
  }
  void store(uint32_t* p) const { _mm512_storeu_si512(p, v); }
};
template <int kBits>
inline WideIntLanes shift_right(WideIntLanes a) {
  return _mm512_srli_epi32(a.v, kBits);
}

// Bit i is the top bit of lane i.
inline uint32_t top_bits(WideIntLanes a) { return _mm512_movepi32_mask(a.v); }

// Compression as by Compress8, for all kLanes lanes.
class CompressWide {
 public:
  explicit CompressWide(uint32_t mask) : mask_(static_cast<__mmask16>(mask)) {}
  [[nodiscard]] WideLanes operator()(WideLanes a) const { return _mm512_maskz_compress_ps(mask_, a.v); }
  [[nodiscard]] WideIntLanes operator()(WideIntLanes a) const { return _mm512_maskz_compress_epi32(mask_, a.v); }

 private:
  __mmask16 mask_;
};

using Lanes16 = WideLanes;
// Lane i of the result is table[low four bits of index[i]].
inline WideLanes pick(Lanes16 table, WideIntLanes index) { return _mm512_permutexvar_ps(index.v, table.v); }
// Lane i of the result has the bits set whose indices are the low four bits of a[i], b[i] and c[i].
inline WideIntLanes bits_of(WideIntLanes a, WideIntLanes b, WideIntLanes c) {
  const __m512i one = _mm512_set1_epi32(1), low = _mm512_set1_epi32(15);
  return _mm512_or_si512(_mm512_or_si512(_mm512_sllv_epi32(one, _mm512_and_si512(a.v, low)),
                                         _mm512_sllv_epi32(one, _mm512_and_si512(b.v, low))),
                         _mm512_sllv_epi32(one, _mm512_and_si512(c.v, low)));
}
// Bit i is set if all bits of lane i are in the set.
inline uint32_t subset_of(WideIntLanes bits, uint32_t set) {
  return _mm512_testn_epi32_mask(bits.v, _mm512_set1_epi32(static_cast<int>(~set)));
}

inline __m512 concatenate(Float4 a, Float4 b, Float4 c, Float4 d) {
  const __m512 ab = _mm512_castps256_ps512(_mm256_insertf128_ps(_mm256_castps128_ps256(a), b, 1));
  return _mm512_insertf32x8(ab, _mm256_insertf128_ps(_mm256_castps128_ps256(c), d, 1), 1);
}
// Transposes sixteen vectors, where vector_at(i) is vector i: out[k] receives lane k of each. Works
// in registers, because a wide load would wait for narrow stores.
template <class VectorAt>
inline void transpose16(const VectorAt& vector_at, const std::array<float*, 4>& out) {
  __m512 v[4]; // vectors i, i + 4, i + 8 and i + 12
  for (uint32_t i = 0; i < 4; ++i)
    v[i] = concatenate(vector_at(i), vector_at(i + 4), vector_at(i + 8), vector_at(i + 12));
  const __m512 ab_low = _mm512_unpacklo_ps(v[0], v[1]), ab_high = _mm512_unpackhi_ps(v[0], v[1]);
  const __m512 cd_low = _mm512_unpacklo_ps(v[2], v[3]), cd_high = _mm512_unpackhi_ps(v[2], v[3]);
  _mm512_store_ps(out[0], _mm512_shuffle_ps(ab_low, cd_low, 0x44));
  _mm512_store_ps(out[1], _mm512_shuffle_ps(ab_low, cd_low, 0xee));
  _mm512_store_ps(out[2], _mm512_shuffle_ps(ab_high, cd_high, 0x44));
  _mm512_store_ps(out[3], _mm512_shuffle_ps(ab_high, cd_high, 0xee));
}

// Bit i is set if the integer whose bits are in lane i, of sixteen aligned ones, is greater than x.
inline uint32_t numbers_above(const float* lanes, uint32_t x) {
  return _mm512_cmpgt_epu32_mask(_mm512_load_si512(lanes), _mm512_set1_epi32(static_cast<int>(x)));
}
// Writes lanes i of x, y, z and w to to(i), which is aligned to 16 bytes.
template <class To>
inline void scatter16(Lanes16 x, Lanes16 y, Lanes16 z, Lanes16 w, const To& to) {
  const __m512 xy_low = _mm512_unpacklo_ps(x.v, y.v), xy_high = _mm512_unpackhi_ps(x.v, y.v);
  const __m512 zw_low = _mm512_unpacklo_ps(z.v, w.v), zw_high = _mm512_unpackhi_ps(z.v, w.v);
  const auto store = [&](__m512 vectors, uint32_t i) { // vectors i, i + 4, i + 8 and i + 12
    _mm_store_ps(to(i), _mm512_castps512_ps128(vectors));
    _mm_store_ps(to(i + 4), _mm512_extractf32x4_ps(vectors, 1));
    _mm_store_ps(to(i + 8), _mm512_extractf32x4_ps(vectors, 2));
    _mm_store_ps(to(i + 12), _mm512_extractf32x4_ps(vectors, 3));
  };
  store(_mm512_shuffle_ps(xy_low, zw_low, 0x44), 0);
  store(_mm512_shuffle_ps(xy_low, zw_low, 0xee), 1);
  store(_mm512_shuffle_ps(xy_high, zw_high, 0x44), 2);
  store(_mm512_shuffle_ps(xy_high, zw_high, 0xee), 3);
}

#else // AVX2

inline uint32_t to_bits(__m256 mask) { return static_cast<uint32_t>(_mm256_movemask_ps(mask)); }
inline uint32_t to_bits(__m256i mask) { return to_bits(_mm256_castsi256_ps(mask)); }
inline uint32_t at_least(Lanes8 a, Lanes8 b) { return to_bits(_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)); }
inline uint32_t at_most(Lanes8 a, Lanes8 b) { return to_bits(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)); }
inline uint32_t above(Lanes8 a, Lanes8 b) { return to_bits(_mm256_cmp_ps(a.v, b.v, _CMP_GT_OQ)); }
inline uint32_t differs(Lanes8 a, Lanes8 b) { return to_bits(_mm256_cmp_ps(a.v, b.v, _CMP_NEQ_OQ)); }
inline uint32_t top_bits(IntLanes8 a) { return to_bits(a.v); }

class Compress8 {
 public:
  explicit Compress8(uint32_t mask) : index_(IntLanes8::from_bytes(tables::kCompress[mask])) {}
  [[nodiscard]] Lanes8 operator()(Lanes8 a) const { return permute(a, index_); }
  [[nodiscard]] IntLanes8 operator()(IntLanes8 a) const { return permute(a, index_); }

 private:
  IntLanes8 index_;
};

inline constexpr uint32_t kLanes = 8;
using WideLanes = Lanes8;
// Sets all bits of lane i to bit i of the mask.
inline __m256i lanes_of(uint32_t mask) {
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask)), bit), bit);
}
inline WideLanes select(uint32_t mask, WideLanes a, WideLanes b) {
  return _mm256_blendv_ps(a.v, b.v, _mm256_castsi256_ps(lanes_of(mask)));
}

struct WideIntLanes : IntLanes8 {
  using IntLanes8::IntLanes8;
  WideIntLanes(IntLanes8 x) : IntLanes8(x) {}
  static WideIntLanes load(const uint32_t* p) { return IntLanes8::load(p); }
  static WideIntLanes load(const uint16_t* p) {
    return WideIntLanes(_mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
  }
};
template <int kBits>
inline WideIntLanes shift_right(WideIntLanes a) {
  return WideIntLanes(_mm256_srli_epi32(a.v, kBits));
}

class CompressWide {
 public:
  explicit CompressWide(uint32_t mask) : compress_(mask) {}
  [[nodiscard]] WideLanes operator()(WideLanes a) const { return compress_(a); }
  [[nodiscard]] WideIntLanes operator()(WideIntLanes a) const { return compress_(static_cast<const IntLanes8&>(a)); }

 private:
  Compress8 compress_;
};

struct Lanes16 {
  Lanes8 low, high;
  Lanes16() = default;
  Lanes16(Lanes8 l, Lanes8 h) : low(l), high(h) {}
  explicit Lanes16(float x) : low(x), high(x) {}
  static Lanes16 load(const float* p) { return {Lanes8::load(p), Lanes8::load(p + 8)}; }
  void store(float* p) const {
    low.store(p);
    high.store(p + 8);
  }
};
inline Lanes16 operator+(const Lanes16& a, const Lanes16& b) { return {a.low + b.low, a.high + b.high}; }
inline Lanes16 operator-(const Lanes16& a, const Lanes16& b) { return {a.low - b.low, a.high - b.high}; }
inline Lanes16 operator*(const Lanes16& a, const Lanes16& b) { return {a.low * b.low, a.high * b.high}; }
inline Lanes16 operator/(const Lanes16& a, const Lanes16& b) { return {a.low / b.low, a.high / b.high}; }
inline Lanes16 min(const Lanes16& a, const Lanes16& b) { return {min(a.low, b.low), min(a.high, b.high)}; }
inline Lanes16 max(const Lanes16& a, const Lanes16& b) { return {max(a.low, b.low), max(a.high, b.high)}; }
inline uint32_t at_least(const Lanes16& a, const Lanes16& b) {
  return at_least(a.low, b.low) | at_least(a.high, b.high) << 8;
}
inline uint32_t at_most(const Lanes16& a, const Lanes16& b) {
  return at_most(a.low, b.low) | at_most(a.high, b.high) << 8;
}
inline uint32_t above(const Lanes16& a, const Lanes16& b) { return above(a.low, b.low) | above(a.high, b.high) << 8; }
inline uint32_t differs(const Lanes16& a, const Lanes16& b) {
  return differs(a.low, b.low) | differs(a.high, b.high) << 8;
}
inline Lanes16 select(uint32_t mask, const Lanes16& a, const Lanes16& b) {
  return {select(mask, a.low, b.low), select(mask >> 8, a.high, b.high)};
}
// See accel/triangle.h.
inline Lanes8 difference_of_products(Lanes8 a, Lanes8 b, Lanes8 c, Lanes8 d) {
  const Lanes8 product = c * d, error = _mm256_fnmadd_ps(c.v, d.v, product.v);
  return Lanes8(_mm256_fmsub_ps(a.v, b.v, product.v)) + error;
}
inline Lanes16 difference_of_products(const Lanes16& a, const Lanes16& b, const Lanes16& c, const Lanes16& d) {
  return {difference_of_products(a.low, b.low, c.low, d.low), difference_of_products(a.high, b.high, c.high, d.high)};
}
inline Lanes16 magnitude(const Lanes16& a) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {_mm256_andnot_ps(sign, a.low.v), _mm256_andnot_ps(sign, a.high.v)};
}
inline uint32_t sign_bits(const Lanes16& a) { return sign_bits(a.low) | sign_bits(a.high) << 8; }
inline float min_lane(const Lanes16& a) {
  const Lanes8 half = min(a.low, a.high);
  const __m128 quarter = _mm_min_ps(_mm256_castps256_ps128(half.v), _mm256_extractf128_ps(half.v, 1));
  const __m128 pair = _mm_min_ps(quarter, _mm_movehl_ps(quarter, quarter));
  return _mm_cvtss_f32(_mm_min_ss(pair, _mm_movehdup_ps(pair)));
}
inline float max_lane(const Lanes16& a) {
  const Lanes8 half = max(a.low, a.high);
  const __m128 quarter = _mm_max_ps(_mm256_castps256_ps128(half.v), _mm256_extractf128_ps(half.v, 1));
  const __m128 pair = _mm_max_ps(quarter, _mm_movehl_ps(quarter, quarter));
  return _mm_cvtss_f32(_mm_max_ss(pair, _mm_movehdup_ps(pair)));
}
inline WideLanes pick(const Lanes16& table, WideIntLanes index) {
  return _mm256_blendv_ps(permute(table.low, index).v, permute(table.high, index).v,
                          _mm256_castsi256_ps(_mm256_slli_epi32(index.v, 28)));
}
// Transposes four pairs of vectors: v[k] receives lane k of the lower halves, then those of the
// upper halves.
inline void transpose_pairs(Lanes8 (&v)[4]) {
  const __m256 ab_low = _mm256_unpacklo_ps(v[0].v, v[1].v), ab_high = _mm256_unpackhi_ps(v[0].v, v[1].v);
  const __m256 cd_low = _mm256_unpacklo_ps(v[2].v, v[3].v), cd_high = _mm256_unpackhi_ps(v[2].v, v[3].v);
  v[0] = _mm256_shuffle_ps(ab_low, cd_low, 0x44);
  v[1] = _mm256_shuffle_ps(ab_low, cd_low, 0xee);
  v[2] = _mm256_shuffle_ps(ab_high, cd_high, 0x44);
  v[3] = _mm256_shuffle_ps(ab_high, cd_high, 0xee);
}
// See the versions for AVX-512.
template <class VectorAt>
inline void transpose16(const VectorAt& vector_at, const std::array<float*, 4>& out) {
  for (uint32_t first = 0; first < 16; first += 8) {
    Lanes8 v[4]; // vectors i and i + 4
    for (uint32_t i = 0; i < 4; ++i)
      v[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(vector_at(first + i)), vector_at(first + i + 4), 1);
    transpose_pairs(v);
    for (uint32_t k = 0; k < 4; ++k) v[k].store(out[k] + first);
  }
}
template <class To>
inline void scatter16(const Lanes16& x, const Lanes16& y, const Lanes16& z, const Lanes16& w, const To& to) {
  const auto scatter8 = [&](Lanes8 a, Lanes8 b, Lanes8 c, Lanes8 d, uint32_t first) {
    Lanes8 v[4] = {a, b, c, d};
    transpose_pairs(v);
    for (uint32_t i = 0; i < 4; ++i) {
      _mm_store_ps(to(first + i), _mm256_castps256_ps128(v[i].v));
      _mm_store_ps(to(first + i + 4), _mm256_extractf128_ps(v[i].v, 1));
    }
  };
  scatter8(x.low, y.low, z.low, w.low, 0);
  scatter8(x.high, y.high, z.high, w.high, 8);
}
inline WideIntLanes bits_of(WideIntLanes a, WideIntLanes b, WideIntLanes c) {
  const __m256i one = _mm256_set1_epi32(1), low = _mm256_set1_epi32(15);
  return WideIntLanes(_mm256_or_si256(_mm256_or_si256(_mm256_sllv_epi32(one, _mm256_and_si256(a.v, low)),
                                                      _mm256_sllv_epi32(one, _mm256_and_si256(b.v, low))),
                                      _mm256_sllv_epi32(one, _mm256_and_si256(c.v, low))));
}
inline uint32_t subset_of(WideIntLanes bits, uint32_t set) {
  const __m256i outside = _mm256_and_si256(bits.v, _mm256_set1_epi32(static_cast<int>(~set)));
  return to_bits(_mm256_cmpeq_epi32(outside, _mm256_setzero_si256()));
}
#endif

} // namespace kindling::accel::kd::KINDLING_SIMD
