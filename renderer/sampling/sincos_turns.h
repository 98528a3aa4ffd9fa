// Sine and cosine of angles in turns, by polynomials.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"

#include <cassert>
#include <cstdint>

namespace kindling {

template <typename Real>
struct SinCosOf {
  Real sin;
  Real cos;
};
using SinCos = SinCosOf<float>;

// Returns the sine and cosine of 2 pi turns, for |turns| < 2^20 (of others, anything). Polynomials
// with an error below 1e-7 give the same bits on every machine, unlike the C library.
template <typename Real>
[[nodiscard]] constexpr SinCosOf<Real> sincos_of_turns(const Real& turns) {
  // The sum with this is rounded to an integer, whose lowest bits are those of the sum.
  constexpr float kRounder = 0x1.8p23f;
  const Real rounded = turns * 4.0f + kRounder;
  const Real quarter = rounded - kRounder;
  const Real a = (turns - quarter * 0.25f) * (2.0f * kPi); // in [-pi/4, pi/4]
  const Real a2 = a * a;
  const Real s =
      a * (1.0f + a2 * (-1.0f / 6.0f + a2 * (1.0f / 120.0f + a2 * (-1.0f / 5040.0f + a2 * (1.0f / 362880.0f)))));
  const Real c = 1.0f + a2 * (-0.5f + a2 * (1.0f / 24.0f + a2 * (-1.0f / 720.0f + a2 * (1.0f / 40320.0f))));
  // Odd quarters swap the two. The sine is negative in quarters 2 and 3, the cosine in 1 and 2.
  const WordsOf<Real> quadrant = bits_of(rounded);
  const auto odd = (quadrant & 1U) != 0U;
  return {from_bits(bits_of(select(odd, c, s)) ^ (quadrant & 2U) << 30),
          from_bits(bits_of(select(odd, s, c)) ^ ((quadrant + 1U) & 2U) << 30)};
}

[[nodiscard]] constexpr SinCos sincos_turns(float turns) {
  assert(!(turns >= 0x1p20f || turns <= -0x1p20f));
  return sincos_of_turns(turns);
}
[[nodiscard]] inline SinCosOf<Lanes> sincos_turns(const Lanes& turns) { return sincos_of_turns(turns); }

} // namespace kindling
