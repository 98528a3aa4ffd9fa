// Powers by polynomials: fast, and bitwise equal on every machine, unlike the math library.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace kindling {

// Returns the base-2 logarithm of a positive, normal float. The absolute error is below 2e-7 near 1
// and below one rounding of the result elsewhere.
[[nodiscard]] inline float fast_log2(float x) {
  // Mantissa in [sqrt(1/2), sqrt(2)), then the series of the inverse hyperbolic tangent.
  const uint32_t bits = std::bit_cast<uint32_t>(x) - 0x3f3504f3U;
  const auto exponent = static_cast<float>(static_cast<int32_t>(bits) >> 23);
  const float m = std::bit_cast<float>((bits & 0x007fffffU) + 0x3f3504f3U);
  const float s = (m - 1.0f) / (m + 1.0f);
  const float s2 = s * s;
  const float series = 2.885390082f + s2 * (0.961796694f + s2 * (0.577078016f + s2 * 0.412198583f));
  return exponent + s * series;
}

// Returns 2^x with a relative error below 3e-7; 0 below 2^-126, clamped at 2^127.
[[nodiscard]] inline float fast_exp2(float x) {
  if (!(x > -126.0f)) return 0.0f;
  x = std::min(x, 127.0f);
  const float whole = std::nearbyint(x);
  const float f = x - whole; // in [-1/2, 1/2]
  const float p =
      1.0f +
      f * (0.693147181f + f * (0.240226507f + f * (0.0555041087f +
                                                   f * (0.00961812911f + f * (0.00133335581f + f * 0.000154035304f)))));
  return p * std::bit_cast<float>((static_cast<uint32_t>(static_cast<int32_t>(whole) + 127)) << 23);
}

// Returns x^y for x >= 0 (0^y is 0).
[[nodiscard]] inline float fast_pow(float x, float y) { return x >= 1.2e-38f ? fast_exp2(y * fast_log2(x)) : 0.0f; }

} // namespace kindling
