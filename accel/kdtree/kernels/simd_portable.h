// SIMD lanes as plain loops: the specification of the intrinsics versions. See simd.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/includes.h"

namespace kindling::accel::kd::KINDLING_SIMD {

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

} // namespace kindling::accel::kd::KINDLING_SIMD
