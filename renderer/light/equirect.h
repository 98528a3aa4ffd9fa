// Equirectangular coordinates of directions by polynomials.
// Several times faster than the C library, and bitwise equal on every machine. Templates compute
// one number or, with Lanes, eight.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"

namespace kindling {

// Returns atan2(y, x) / (2 pi), in [-0.5, 0.5], with an absolute error below 2e-7; 0 for (0, 0).
// The arctangent is Abramowitz & Stegun 4.4.49 on [0, 1], scaled to turns.
template <typename Real>
[[nodiscard]] Real atan2_turns(const Real& y, const Real& x) {
  const Real ax = absolute(x);
  const Real ay = absolute(y);
  const Real longer = select(ax > ay, ax, ay);
  const Real shorter = select(ax > ay, ay, ax);
  const Real t = shorter / select(longer > 0.0f, longer, Real(1.0f));
  const Real s = t * t;
  // Estrin's scheme: shorter dependency chains than Horner's.
  const Real s2 = s * s;
  const Real s4 = s2 * s2;
  constexpr float k = 0.15915494309f; // 1 / (2 pi)
  const Real p01 = k * 1.0f + s * (k * -0.3333314528f);
  const Real p23 = k * 0.1999355085f + s * (k * -0.1420889944f);
  const Real p45 = k * 0.1065626393f + s * (k * -0.0752896400f);
  const Real p67 = k * 0.0429096138f + s * (k * -0.0161657367f);
  const Real high = (p45 + s2 * p67) + s4 * (k * 0.0028662257f);
  Real turns = t * ((p01 + s2 * p23) + s4 * high);
  turns = select(ay > ax, Real(0.25f - turns), turns);
  turns = select(x < 0.0f, Real(0.5f - turns), turns);
  return with_sign_of(turns, y);
}

// Returns acos(c) / pi, in [0, 1], with an absolute error below 2e-7. |c| > 1 counts as 1.
// Abramowitz & Stegun 4.4.46.
template <typename Real>
[[nodiscard]] Real acos_half_turns(const Real& c) {
  const Real a = minimum(absolute(c), Real(1.0f));
  const Real a2 = a * a;
  const Real a4 = a2 * a2;
  constexpr float k = kInvPi;
  const Real p01 = k * 1.5707963050f + a * (k * -0.2145988016f);
  const Real p23 = k * 0.0889789874f + a * (k * -0.0501743046f);
  const Real p45 = k * 0.0308918810f + a * (k * -0.0170881256f);
  const Real p67 = k * 0.0066700901f + a * (k * -0.0012624911f);
  const Real r = square_root(Real(1.0f - a)) * ((p01 + a2 * p23) + a4 * (p45 + a2 * p67));
  return select(c < 0.0f, Real(1.0f - r), r);
}

} // namespace kindling
