// Rows of eight numbers: the boxes of a node's children are tested at once, without a branch.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/vectors.h"

namespace kindling::accel::kd::compact {

// Vectors wider than the target's registers are passed in memory; all functions are inlined, so no
// binary interface depends on it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

// Rows as nodes store them. A GPU reads four numbers at a time, because it knows that rows are
// aligned.
using AlignedRow = float __attribute__((vector_size(32), may_alias));
using AlignedChildren = int32_t __attribute__((vector_size(32), may_alias));
static_assert(alignof(AlignedRow) <= sizeof(Float8));
[[nodiscard, gnu::always_inline]] inline Float8 row_at(const float* row) {
  return *reinterpret_cast<const AlignedRow*>(row);
}

// The larger and the smaller number of each lane; b where `a` is NaN.
[[nodiscard]] inline Float8 larger(const Float8& a, const Float8& b) {
#ifdef __NVPTX__
  return __builtin_elementwise_max(a, b); // an instruction for each lane instead of two
#else
  return vector_max(a, b);
#endif
}
[[nodiscard]] inline Float8 smaller(const Float8& a, const Float8& b) {
#ifdef __NVPTX__
  return __builtin_elementwise_min(a, b);
#else
  return vector_min(a, b);
#endif
}

#pragma GCC diagnostic pop

// Returns a value that the compiler knows nothing about. Else it would let a thread of a GPU jump
// past tests whose result it knows, and threads that took different ways would not meet there.
template <class T>
[[nodiscard, gnu::always_inline]] inline T meet(T value) {
#ifdef __NVPTX__
  if constexpr (sizeof(T) == 8)
    asm volatile("" : "+l"(value));
  else
    asm volatile("" : "+r"(value));
#endif
  return value;
}

} // namespace kindling::accel::kd::compact
