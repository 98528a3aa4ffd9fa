// Weights of multiple importance sampling: the power heuristic.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"

#include <cassert>
#include <cmath>

namespace kindling {

// Returns the weight of a sample drawn with density pdf_a if a second technique has density pdf_b
// there and each takes one sample: the power heuristic with exponent 2 (Veach 1997, section 9.2.4).
// Both densities are >= 0 and in the same measure; infinity stands for a delta distribution. The
// weight is in [0, 1]; the weights of both techniques add up to 1 wherever a density is positive.
// It never overflows and is never NaN.
[[nodiscard]] inline float power_heuristic(float pdf_a, float pdf_b) {
  assert(!(pdf_a < 0.0f) && !(pdf_b < 0.0f));
  if (!(pdf_a > 0.0f)) return 0.0f;
  const float ratio = pdf_b / pdf_a;
  if (std::isnan(ratio)) return 0.5f; // two infinities
  return 1.0f / (1.0f + ratio * ratio);
}
// Those of eight samples, with the same bits.
[[nodiscard]] inline Lanes power_heuristic(const Lanes& pdf_a, const Lanes& pdf_b) {
  const Lanes ratio = pdf_b / pdf_a, weight = 1.0f / (1.0f + ratio * ratio);
  const LaneMask is_number = ratio <= kInfinity; // else NaN
  return select(pdf_a > 0.0f, select(is_number, weight, Lanes(0.5f)), Lanes(0.0f));
}

} // namespace kindling
