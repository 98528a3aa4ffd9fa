// The bounds of four references across an axis, in one vector.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/kdtree/build/reference.h"
#include "accel/vectors.h"

#include <cstddef>

namespace kindling::accel::kd {

// Takes all lanes of four references; returns their lower bounds, then their upper bounds.
template <size_t kAxis>
[[nodiscard, gnu::always_inline]] inline Float8 bounds_across(Float8 a, Float8 b, Float8 c, Float8 d) {
  constexpr int k = static_cast<int>(kAxis);
  const Float8 ab = __builtin_shufflevector(a, b, k, k, k + 8, k + 8, k + 4, k + 4, k + 12, k + 12),
               cd = __builtin_shufflevector(c, d, k, k, k + 8, k + 8, k + 4, k + 4, k + 12, k + 12);
  return __builtin_shufflevector(ab, cd, 0, 2, 8, 10, 4, 6, 12, 14);
}

} // namespace kindling::accel::kd
