// Short vectors in the vector extensions of GCC and Clang, and operations on them.
// The compiler maps them to whatever registers the target has, with equal results.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

namespace kindling::accel::kd {

using Float4 = float __attribute__((vector_size(16)));
using Float8Lanes = float __attribute__((vector_size(32)));
using Int8Lanes = int32_t __attribute__((vector_size(32)));
using Double4 = double __attribute__((vector_size(32)));

// Lane-wise minimum and maximum; return b in lanes where either is NaN.
template <class V>
[[nodiscard]] inline V least(V a, V b) {
  return a < b ? a : b;
}
template <class V>
[[nodiscard]] inline V greatest(V a, V b) {
  return a > b ? a : b;
}

// Loads and stores at addresses of any alignment.
template <class V>
[[nodiscard]] inline V load_lanes(const void* from) {
  V v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <class V>
inline void store_lanes(void* to, V v) {
  std::memcpy(to, &v, sizeof v);
}
[[nodiscard]] inline Float8Lanes spread(float x) { return Float8Lanes{x, x, x, x, x, x, x, x}; }
[[nodiscard]] inline Double4 spread(double x) { return Double4{x, x, x, x}; }

} // namespace kindling::accel::kd
