// Powers by polynomials: fast, and bitwise equal on every machine, unlike the math library.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"

#include <cstdint>
#include <type_traits>

namespace kindling {

// Adding it to a number below 2^22 rounds to an integer, which the lowest bits of the sum hold.
inline constexpr float kIntegerRounder = 0x1.8p23f;

// Returns the base-2 logarithm of a positive, normal float. The absolute error is below 2e-7 near 1
// and below one rounding of the result elsewhere.
template <typename Real>
[[nodiscard]] Real fast_log2(const Real& x) {
  // Mantissa in [sqrt(1/2), sqrt(2)), then the series of the inverse hyperbolic tangent.
  const WordsOf<Real> bits = bits_of(x) - 0x3f3504f3U;
  const WordsOf<Real> exponent = ((bits >> 23) ^ 0x100U) - 0x100U; // its sign extended
  const Real whole = from_bits(exponent + bits_of(kIntegerRounder)) - kIntegerRounder;
  const Real m = from_bits((bits & 0x007fffffU) + 0x3f3504f3U);
  const Real s = (m - 1.0f) / (m + 1.0f);
  const Real s2 = s * s;
  const Real series = 2.885390082f + s2 * (0.961796694f + s2 * (0.577078016f + s2 * 0.412198583f));
  return whole + s * series;
}

// Returns 2^x with a relative error below 3e-7; 0 below 2^-126, clamped at 2^127.
template <typename Real>
[[nodiscard]] Real fast_exp2(const Real& x) {
  const Real clamped = minimum(maximum(Real(-126.0f), x), Real(127.0f)); // -126 for NaN
  const Real rounded = clamped + kIntegerRounder;
  const Real f = clamped - (rounded - kIntegerRounder); // in [-1/2, 1/2]
  const Real p =
      1.0f +
      f * (0.693147181f + f * (0.240226507f + f * (0.0555041087f +
                                                   f * (0.00961812911f + f * (0.00133335581f + f * 0.000154035304f)))));
  const Real power = p * from_bits((bits_of(rounded) - bits_of(kIntegerRounder) + 127U) << 23);
  return select(x > -126.0f, power, Real(0.0f));
}

// Returns x^y for x >= 0 (0^y is 0).
template <typename Real>
[[nodiscard]] Real fast_pow(const Real& x, const std::type_identity_t<Real>& y) {
  return select(x >= 1.2e-38f, fast_exp2(Real(y * fast_log2(x))), Real(0.0f));
}

} // namespace kindling
