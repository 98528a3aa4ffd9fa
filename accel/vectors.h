// Short vectors in the vector extensions of GCC and Clang, and operations on them.
//
// The compiler maps them to whatever registers the target has, with equal results. The kd-tree's
// kernels use them too, beside lanes of their own in intrinsics (kdtree/kernels/simd.h).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

namespace kindling::accel {

using Float4 = float __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Int4 = int32_t __attribute__((vector_size(16)));
using Int8 = int32_t __attribute__((vector_size(32)));
using Double4 = double __attribute__((vector_size(32)));

// Vectors wider than the target's registers are passed in memory; all functions are inlined, so no
// binary interface depends on it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

// Lane-wise minimum and maximum; return b in lanes where either is NaN.
template <class V>
[[nodiscard]] inline V vector_min(V a, V b) {
  return a < b ? a : b;
}
template <class V>
[[nodiscard]] inline V vector_max(V a, V b) {
  return a > b ? a : b;
}

// Loads and stores at addresses of any alignment.
template <class V>
[[nodiscard]] inline V load_vector(const void* from) {
  V v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <class V>
inline void store_vector(void* to, V v) {
  std::memcpy(to, &v, sizeof v);
}
// Bit i is the sign of lane i.
[[nodiscard]] inline uint32_t sign_bits(Int8 a) {
#if defined(__AVX2__)
  return static_cast<uint32_t>(__builtin_ia32_movmskps256(std::bit_cast<Float8>(a)));
#else
  uint32_t bits = 0;
  for (int i = 0; i < 8; ++i) bits |= (static_cast<uint32_t>(a[i]) >> 31) << i;
  return bits;
#endif
}
[[nodiscard]] inline Float8 splat(float x) { return Float8{x, x, x, x, x, x, x, x}; }
[[nodiscard]] inline Double4 splat(double x) { return Double4{x, x, x, x}; }

#pragma GCC diagnostic pop

// Transposes a 4 x 4 matrix of rows.
[[gnu::always_inline]] inline void transpose(Float4 (&m)[4]) {
  const Float4 a = __builtin_shufflevector(m[0], m[1], 0, 4, 1, 5), b = __builtin_shufflevector(m[0], m[1], 2, 6, 3, 7),
               c = __builtin_shufflevector(m[2], m[3], 0, 4, 1, 5), d = __builtin_shufflevector(m[2], m[3], 2, 6, 3, 7);
  m[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  m[1] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  m[2] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  m[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

} // namespace kindling::accel
