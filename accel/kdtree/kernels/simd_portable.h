// SIMD lanes as plain loops: the specification of the intrinsics versions. See simd.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/kernels/includes.h"

namespace kindling::accel::kd::KINDLING_SIMD {

template <class T, uint32_t N>
struct alignas(sizeof(T) * N) LanesOf {
  std::array<T, N> v;
  LanesOf() = default;
  explicit LanesOf(T x) { v.fill(x); }
  template <class S>
  static LanesOf load(const S* p) {
    LanesOf r;
    for (uint32_t i = 0; i < N; ++i) r.v[i] = p[i];
    return r;
  }
  static LanesOf load_twice(const T* p) {
    LanesOf r;
    for (uint32_t i = 0; i < N; ++i) r.v[i] = p[i % (N / 2)];
    return r;
  }
  static LanesOf from_bytes(uint64_t bytes) {
    LanesOf r;
    for (uint32_t i = 0; i < N; ++i) r.v[i] = static_cast<T>((bytes >> (8 * i)) & 0xffU);
    return r;
  }
  void store(T* p) const { std::memcpy(p, v.data(), sizeof(v)); }
};
using Lanes8 = LanesOf<float, 8>;
using IntLanes8 = LanesOf<uint32_t, 8>;

template <class T, uint32_t N, class F>
inline LanesOf<T, N> combine(const LanesOf<T, N>& a, const LanesOf<T, N>& b, F f) {
  LanesOf<T, N> r;
  for (uint32_t i = 0; i < N; ++i) r.v[i] = f(a.v[i], b.v[i]);
  return r;
}
template <class T, uint32_t N, class F>
inline uint32_t compare(const LanesOf<T, N>& a, const LanesOf<T, N>& b, F f) {
  uint32_t r = 0;
  for (uint32_t i = 0; i < N; ++i) r |= static_cast<uint32_t>(f(a.v[i], b.v[i])) << i;
  return r;
}
template <uint32_t N>
inline LanesOf<float, N> operator+(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x + y; });
}
template <uint32_t N>
inline LanesOf<float, N> operator-(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x - y; });
}
template <uint32_t N>
inline LanesOf<float, N> operator*(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x * y; });
}
template <uint32_t N>
inline LanesOf<float, N> operator/(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x / y; });
}
template <uint32_t N>
inline LanesOf<float, N> min(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x < y ? x : y; });
}
template <uint32_t N>
inline LanesOf<float, N> max(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return combine(a, b, [](float x, float y) { return x > y ? x : y; });
}
template <uint32_t N>
inline uint32_t at_least(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return compare(a, b, [](float x, float y) { return x >= y; });
}
template <uint32_t N>
inline uint32_t at_most(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return compare(a, b, [](float x, float y) { return x <= y; });
}
template <uint32_t N>
inline uint32_t above(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return compare(a, b, [](float x, float y) { return x > y; });
}
template <uint32_t N>
inline uint32_t differs(const LanesOf<float, N>& a, const LanesOf<float, N>& b) {
  return compare(a, b, [](float x, float y) { return x < y || x > y; });
}
template <uint32_t N>
inline uint32_t sign_bits(const LanesOf<float, N>& a) {
  return compare(a, a, [](float x, float) { return std::bit_cast<uint32_t>(x) >> 31; });
}
template <class T, uint32_t N>
inline LanesOf<T, N> select(uint32_t mask, const LanesOf<T, N>& a, const LanesOf<T, N>& b) {
  LanesOf<T, N> r;
  for (uint32_t i = 0; i < N; ++i) r.v[i] = ((mask >> i) & 1U) != 0 ? b.v[i] : a.v[i];
  return r;
}
template <int kBits>
inline IntLanes8 shift_right(IntLanes8 a) {
  for (uint32_t& x : a.v) x >>= kBits;
  return a;
}
inline IntLanes8 shift_by_nibbles(IntLanes8 a) {
  for (uint32_t i = 0; i < 8; ++i) a.v[i] >>= 4 * i;
  return a;
}
template <class T>
inline LanesOf<T, 8> permute(const LanesOf<T, 8>& a, const IntLanes8& index) {
  LanesOf<T, 8> r;
  for (uint32_t i = 0; i < 8; ++i) r.v[i] = a.v[index.v[i] & 7];
  return r;
}
inline void prefetch(const void* p) { __builtin_prefetch(p); }

class Compress8 {
 public:
  explicit Compress8(uint32_t mask) : index_(IntLanes8::from_bytes(tables::kCompress[mask])) {}
  template <class T>
  [[nodiscard]] LanesOf<T, 8> operator()(const LanesOf<T, 8>& a) const {
    return permute(a, index_);
  }

 private:
  IntLanes8 index_;
};

inline constexpr uint32_t kLanes = 8;
using WideLanes = Lanes8;
using WideIntLanes = IntLanes8;
inline uint32_t top_bits(const WideIntLanes& a) {
  return compare(a, a, [](uint32_t x, uint32_t) { return x >> 31; });
}
using CompressWide = Compress8;
using Lanes16 = LanesOf<float, 16>;
inline WideLanes pick(const Lanes16& table, const WideIntLanes& index) {
  WideLanes r;
  for (uint32_t i = 0; i < kLanes; ++i) r.v[i] = table.v[index.v[i] & 15];
  return r;
}
// See accel/triangle.h.
template <uint32_t N>
inline LanesOf<float, N> difference_of_products(const LanesOf<float, N>& a, const LanesOf<float, N>& b,
                                                const LanesOf<float, N>& c, const LanesOf<float, N>& d) {
  LanesOf<float, N> r;
  for (size_t i = 0; i < N; ++i) r.v[i] = accel::difference_of_products(a.v[i], b.v[i], c.v[i], d.v[i]);
  return r;
}
inline Lanes16 magnitude(Lanes16 a) {
  for (float& x : a.v) x = std::fabs(x);
  return a;
}
inline float min_lane(const Lanes16& a) { return *std::min_element(a.v.begin(), a.v.end()); }
inline float max_lane(const Lanes16& a) { return *std::max_element(a.v.begin(), a.v.end()); }
inline WideIntLanes bits_of(const WideIntLanes& a, const WideIntLanes& b, const WideIntLanes& c) {
  WideIntLanes r;
  for (uint32_t i = 0; i < kLanes; ++i) r.v[i] = 1U << (a.v[i] & 15) | 1U << (b.v[i] & 15) | 1U << (c.v[i] & 15);
  return r;
}
inline uint32_t subset_of(const WideIntLanes& bits, uint32_t set) {
  return compare(bits, WideIntLanes(~set), [](uint32_t x, uint32_t y) { return (x & y) == 0; });
}

} // namespace kindling::accel::kd::KINDLING_SIMD
