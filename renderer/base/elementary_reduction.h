// Reduction of angles of any size to a quadrant and a rest, exact to the last bit that matters.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary_coefficients.h"

#include <bit>
#include <cstdint>

namespace kindling::elementary {

// A sum of two doubles, the second at most half a unit in the last place of the first.
struct DoublePair {
  double high;
  double low;
};

// Returns a + b exactly (Knuth 1969; Moeller 1965).
[[nodiscard]] constexpr DoublePair exact_sum(double a, double b) {
  const double sum = a + b;
  const double part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

// Returns a * b exactly, for |a|, |b| < 2^996 and products above 2^-968 (Dekker 1971). It uses no
// fused multiply-add, which not every target has.
[[nodiscard]] constexpr DoublePair exact_product(double a, double b) {
  constexpr double kSplit = 0x1p27 + 1.0;
  const double a_wide = kSplit * a, b_wide = kSplit * b;
  const double a_high = a_wide - (a_wide - a), b_high = b_wide - (b_wide - b);
  const double a_low = a - a_high, b_low = b - b_high;
  const double product = a * b;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

// Returns a / b with an error near 2^-104.
[[nodiscard]] constexpr DoublePair quotient(const DoublePair& a, const DoublePair& b) {
  const double high = a.high / b.high;
  const DoublePair back = exact_product(high, b.high);
  return {high, (((a.high - back.high) - back.low) + (a.low - high * b.low)) / b.high};
}

// An angle less its nearest multiple of pi / 2: angle = quadrant pi / 2 + high + low.
struct ReducedAngle {
  double high = 0.0;
  double low = 0.0;
  uint64_t quadrant = 0; // its two lowest bits count
};

// Reduces any |x| >= 2^-2; the result is NaN for infinity and NaN. Payne and Hanek 1983, "Radian
// Reduction for Trigonometric Functions": of the product with 2 / pi only those bits are computed
// that decide the quadrant and the rest, to 137 bits behind the point. No double is nearer to a
// multiple of pi / 2 than 2^-62 of its own size.
[[nodiscard]] constexpr ReducedAngle reduce_any_angle(double x) {
  using Wide = unsigned __int128;
  const auto bits = std::bit_cast<uint64_t>(x);
  const auto exponent = static_cast<int>(bits >> 52 & 0x7ff);
  if (exponent == 0x7ff) return {x - x, 0.0, 0};
  const uint64_t mantissa = (bits & 0x000fffffffffffff) | 0x0010000000000000;
  // x = mantissa 2^(exponent - 1075). Bits of 2 / pi before `first` give multiples of 4 quadrants.
  const auto first = static_cast<unsigned>(exponent - 1077 + 64);
  const unsigned word = first / 64, shift = first % 64;
  uint64_t window[3] = {};
  for (unsigned i = 0; i < 3; ++i) {
    const uint64_t after = kTwoOverPiBits[word + i + 1];
    window[i] = kTwoOverPiBits[word + i] << shift | (shift == 0 ? 0 : after >> (64 - shift));
  }
  // The product in quadrants, modulo 4: 2 bits before the point, 190 behind.
  const Wide last = static_cast<Wide>(mantissa) * window[2];
  const Wide middle = static_cast<Wide>(mantissa) * window[1] + static_cast<uint64_t>(last >> 64);
  uint64_t p0 = mantissa * window[0] + static_cast<uint64_t>(middle >> 64);
  auto p1 = static_cast<uint64_t>(middle);
  auto p2 = static_cast<uint64_t>(last);
  uint64_t quadrant = (p0 + (uint64_t{1} << 61)) >> 62;
  p0 -= quadrant << 62; // now a signed number in [-1/2, 1/2)
  bool negative = p0 >> 63 != 0;
  if (negative) {
    p2 = ~p2 + 1;
    p1 = ~p1 + (p2 == 0 ? 1 : 0);
    p0 = ~p0 + (p1 == 0 && p2 == 0 ? 1 : 0);
  }
  // The first bit moves to the top; it is one of the first 63 + 64.
  int leading = 2; // bits before the point
  if (p0 == 0) {
    p0 = p1;
    p1 = p2;
    p2 = 0;
    leading -= 64;
  }
  const int zeros = std::countl_zero(p0);
  if (zeros > 0 && zeros < 64) {
    p0 = p0 << zeros | p1 >> (64 - zeros);
    p1 = p1 << zeros | p2 >> (64 - zeros);
  }
  leading -= zeros;
  if (bits >> 63 != 0) { // the reduction is odd
    negative = !negative;
    quadrant = 0 - quadrant;
  }
  // 53 bits and the next 53, each exact; powers of two are put together from their bits.
  const auto scale = [&](int power) { return std::bit_cast<double>(static_cast<uint64_t>(power + 1023) << 52); };
  const double sign = negative ? -1.0 : 1.0;
  const double high = sign * static_cast<double>(p0 >> 11) * scale(leading - 53);
  const double low = sign * static_cast<double>((p0 & 0x7ff) << 42 | p1 >> 22) * scale(leading - 106);
  const DoublePair product = exact_product(high, kHalfPi);
  const double rest = product.low + (high * kHalfPiRest + low * kHalfPi);
  const double sum = product.high + rest;
  return {sum, rest - (sum - product.high), quadrant};
}

} // namespace kindling::elementary
