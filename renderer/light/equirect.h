// Equirectangular coordinates of directions by polynomials.
// Several times faster than the C library, and bitwise equal on every machine.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <cmath>

namespace kindling {

// Returns atan2(y, x) / (2 pi), in [-0.5, 0.5], with an absolute error below 2e-7; 0 for (0, 0).
// The arctangent is Abramowitz & Stegun 4.4.49 on [0, 1], scaled to turns.
[[nodiscard]] inline float atan2_turns(float y, float x) {
  const float ax = std::fabs(x);
  const float ay = std::fabs(y);
  const float longer = ax > ay ? ax : ay;
  const float shorter = ax > ay ? ay : ax;
  const float t = shorter / (longer > 0.0f ? longer : 1.0f);
  const float s = t * t;
  // Estrin's scheme: shorter dependency chains than Horner's.
  const float s2 = s * s;
  const float s4 = s2 * s2;
  constexpr float k = 0.15915494309f; // 1 / (2 pi)
  const float p01 = k * 1.0f + s * (k * -0.3333314528f);
  const float p23 = k * 0.1999355085f + s * (k * -0.1420889944f);
  const float p45 = k * 0.1065626393f + s * (k * -0.0752896400f);
  const float p67 = k * 0.0429096138f + s * (k * -0.0161657367f);
  const float high = (p45 + s2 * p67) + s4 * (k * 0.0028662257f);
  float turns = t * ((p01 + s2 * p23) + s4 * high);
  turns = ay > ax ? 0.25f - turns : turns;
  turns = x < 0.0f ? 0.5f - turns : turns;
  return std::copysign(turns, y);
}

// Returns acos(c) / pi, in [0, 1], with an absolute error below 2e-7. |c| > 1 counts as 1.
// Abramowitz & Stegun 4.4.46.
[[nodiscard]] inline float acos_half_turns(float c) {
  const float a = std::min(std::fabs(c), 1.0f);
  const float a2 = a * a;
  const float a4 = a2 * a2;
  constexpr float k = kInvPi;
  const float p01 = k * 1.5707963050f + a * (k * -0.2145988016f);
  const float p23 = k * 0.0889789874f + a * (k * -0.0501743046f);
  const float p45 = k * 0.0308918810f + a * (k * -0.0170881256f);
  const float p67 = k * 0.0066700901f + a * (k * -0.0012624911f);
  const float r = std::sqrt(1.0f - a) * ((p01 + a2 * p23) + a4 * (p45 + a2 * p67));
  return c < 0.0f ? 1.0f - r : r;
}

} // namespace kindling
