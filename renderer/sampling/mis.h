// How two sampling techniques share one integrand: multiple importance sampling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace kindling {

// Weight of a sample drawn with density pdf_a when another technique, one sample each, has density pdf_b there: the
// power heuristic with exponent 2 (Veach 1997, section 9.2.4). Both densities >= 0 in one measure; infinite stands for
// a delta. In [0, 1]; weights of the two techniques add up to 1 wherever one density is positive. No overflow; never
// NaN.
[[nodiscard]] inline float power_heuristic(float pdf_a, float pdf_b) {
  if (!(pdf_a > 0.0f)) return 0.0f;
  const float ratio = pdf_b / pdf_a;
  if (std::isnan(ratio)) return 0.5f; // two infinities
  return 1.0f / (1.0f + ratio * ratio);
}

} // namespace kindling
