// Elementary functions of floats that give the same bits on every machine and by every compiler.
//
// They use additions, products, quotients and square roots of doubles, which IEEE 754 defines to
// the last bit, and operations on bits: no table, no C library, no fused multiply-add (sources must
// be compiled with -ffp-contract=off). There are no branches but in pow() and for huge angles, so
// that loops over the others become vector code.
//
// Errors are at most 0.57 units in the last place over all floats (tests/base/elementary_test.cpp
// measures them). Special values are those of C's Annex F: signed zeros, infinities, NaN. Denormal
// arguments and results follow the mode of the thread, which may flush them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary_coefficients.h"
#include "renderer/base/elementary_reduction.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace kindling::elementary {

// Returns c[0] + c[1] x + ... by Estrin's scheme, whose chains of dependent operations are shorter
// than Horner's.
template <size_t kCount>
[[nodiscard]] constexpr double polynomial(const double (&c)[kCount], double x) {
  static_assert(kCount >= 3 && kCount <= 6);
  const double x2 = x * x;
  if constexpr (kCount == 3) return (c[0] + c[1] * x) + c[2] * x2;
  if constexpr (kCount == 4) return (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2;
  if constexpr (kCount == 5) return ((c[0] + c[1] * x) + (c[2] + c[3] * x) * x2) + c[4] * (x2 * x2);
  if constexpr (kCount == 6) return ((c[0] + c[1] * x) + (c[2] + c[3] * x) * x2) + (c[4] + c[5] * x) * (x2 * x2);
}

// The sum of this and x is rounded to an integer, whose lowest bits are those of the sum; for |x| <
// 2^51.
inline constexpr double kRounder = 0x1.8p52;

// Returns 2^t rounded once.
[[nodiscard]] constexpr float float_exp2(double t) {
  t = t < -160.0 ? -160.0 : t; // NaN remains
  t = t > 130.0 ? 130.0 : t;
  const double rounded = t + kRounder;
  const auto scale = std::bit_cast<double>((std::bit_cast<uint64_t>(rounded) + 1023) << 52);
  const double r = t - (rounded - kRounder);
  const double r2 = r * r;
  const double high = (kExp2Short[3] + kExp2Short[4] * r) + kExp2Short[5] * r2;
  const double low = (1.0 + kExp2Short[0] * r) + (kExp2Short[1] + kExp2Short[2] * r) * r2;
  return static_cast<float>((low + high * (r2 * r2)) * scale);
}

[[nodiscard]] constexpr float exp2(float x) { return float_exp2(static_cast<double>(x)); }
[[nodiscard]] constexpr float exp(float x) { return float_exp2(static_cast<double>(x) * kLog2E); }

// x = 2^exponent (1 + s) / (1 - s), the quotient between sqrt(1/2) and sqrt(2).
struct LogParts {
  double exponent;
  double s;
};

// Splits a positive, normal double.
[[nodiscard]] constexpr LogParts split_logarithm(double x) {
  constexpr uint64_t kRootHalf = 0x3fe6a09e667f3bcd;
  const uint64_t u = std::bit_cast<uint64_t>(x) - kRootHalf + (uint64_t{1024} << 52);
  const auto m = std::bit_cast<double>((u & 0x000fffffffffffff) + kRootHalf);
  // An integer in the lowest bits of 2^52 is a conversion that vector units have, too.
  return {std::bit_cast<double>(u >> 52 | 0x4330000000000000) - (0x1p52 + 1024.0), (m - 1.0) / (m + 1.0)};
}

// Returns what a logarithm is at 0, negative numbers, infinity and NaN, else the value given.
[[nodiscard]] constexpr float logarithm_of(float x, double value) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const float edge = x == 0.0f ? -kInfinite : std::numeric_limits<float>::quiet_NaN();
  const float result = x > 0.0f ? static_cast<float>(value) : edge;
  return x < kInfinite ? result : x + x;
}

[[nodiscard]] constexpr float log(float x) {
  const LogParts p = split_logarithm(static_cast<double>(x));
  const double z = p.s * p.s;
  return logarithm_of(x, p.exponent * kLn2 + p.s * (2.0 + z * polynomial(kLogShort, z)));
}

[[nodiscard]] constexpr float log2(float x) {
  const LogParts p = split_logarithm(static_cast<double>(x));
  const double z = p.s * p.s;
  return logarithm_of(x, p.exponent + p.s * (2.0 * kLog2E + z * polynomial(kLog2Short, z)));
}

// Returns x^y for zeros, negative numbers, infinities and NaN.
[[nodiscard]] constexpr float special_pow(float x, float y);

// Returns x^y. Negative x have powers of integer y.
[[nodiscard]] constexpr float pow(float x, float y) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  if (!(x > 0.0f && x < kInfinite && y > -kInfinite && y < kInfinite)) [[unlikely]]
    return special_pow(x, y);
  const LogParts p = split_logarithm(static_cast<double>(x));
  const double z = p.s * p.s;
  const double exponent = p.exponent + p.s * (2.0 * kLog2E + z * polynomial(kLog2Medium, z));
  return float_exp2(static_cast<double>(y) * exponent);
}

constexpr float special_pow(float x, float y) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const bool y_infinite = y == kInfinite || y == -kInfinite;
  if (y == 0.0f || x == 1.0f || (x == -1.0f && y_infinite)) return 1.0f;
  if (x != x || y != y) return x + y;
  const auto base = std::bit_cast<float>(std::bit_cast<uint32_t>(x) & 0x7fffffffU);
  const bool grows = (base > 1.0f) == (y > 0.0f);
  const bool is_limit = y_infinite || base == 0.0f || base == kInfinite;
  const float result = is_limit ? (grows ? kInfinite : 0.0f) : pow(base, y);
  if (std::bit_cast<int32_t>(x) >= 0 || y_infinite) return result;
  // All floats from 2^24 on are even integers.
  const auto power = static_cast<double>(y);
  const auto whole = [](double v) { return (v + kRounder) - kRounder == v; };
  const bool large = !(power > -0x1p24 && power < 0x1p24);
  if (base > 0.0f && base < kInfinite && !large && !whole(power)) return std::numeric_limits<float>::quiet_NaN();
  return !large && whole(power) && !whole(0.5 * power) ? -result : result;
}

// Reduces an angle to [-pi/4, pi/4], with an error far below that of a float's rounding.
[[nodiscard]] constexpr ReducedAngle reduce_angle(float angle) {
  const auto x = static_cast<double>(angle);
  // Cody and Waite 1980: the first product is exact, and so is the difference.
  if (x > -0x1p20 && x < 0x1p20) [[likely]] {
    const double rounded = x * kTwoOverPi + kRounder;
    const double quadrants = rounded - kRounder;
    return {(x - quadrants * kHalfPiUpper) - quadrants * kHalfPiLower, 0.0, std::bit_cast<uint64_t>(rounded)};
  }
  return reduce_any_angle(x);
}

// Returns the sine of the reduced angle, or its cosine in odd quadrants, with its sign.
[[nodiscard]] constexpr float float_sine(double r, uint64_t quadrant) {
  const double z = r * r;
  const double sine = r * (1.0 + z * polynomial(kSinShort, z));
  const double cosine = 1.0 + z * polynomial(kCosShort, z);
  const double value = (quadrant & 1) != 0 ? cosine : sine;
  return static_cast<float>(std::bit_cast<double>(std::bit_cast<uint64_t>(value) ^ (quadrant & 2) << 62));
}

[[nodiscard]] constexpr float sin(float x) {
  const ReducedAngle a = reduce_angle(x);
  return float_sine(a.high, a.quadrant);
}
[[nodiscard]] constexpr float cos(float x) {
  const ReducedAngle a = reduce_angle(x);
  return float_sine(a.high, a.quadrant + 1);
}
[[nodiscard]] constexpr float tan(float x) {
  const ReducedAngle a = reduce_angle(x);
  const double z = a.high * a.high;
  const double sine = a.high * (1.0 + z * polynomial(kSinShort, z));
  const double cosine = 1.0 + z * polynomial(kCosShort, z);
  const bool odd = (a.quadrant & 1) != 0;
  return static_cast<float>((odd ? -cosine : sine) / (odd ? sine : cosine));
}

// Returns magnitude, which is not negative, with the sign of `sign`.
[[nodiscard]] constexpr float with_sign(double magnitude, float sign) {
  const uint32_t bits = std::bit_cast<uint32_t>(static_cast<float>(magnitude));
  return std::bit_cast<float>(bits | (std::bit_cast<uint32_t>(sign) & 0x80000000U));
}

// The arcsine of a = |x| is `value` if a <= 1/2, else pi / 2 - 2 value; NaN beyond 1.
struct ArcsineParts {
  bool large;
  double value;
};
[[nodiscard]] inline ArcsineParts arcsine_parts(double a) {
  const bool large = a > 0.5;
  const double z = large ? (1.0 - a) * 0.5 : a * a;
  const double s = large ? std::sqrt(z) : a;
  return {large, s * (1.0 + z * polynomial(kAsinShort, z))};
}

[[nodiscard]] inline float asin(float x) {
  const ArcsineParts p = arcsine_parts(std::fabs(static_cast<double>(x)));
  return with_sign(p.large ? kHalfPi - 2.0 * p.value : p.value, x);
}
[[nodiscard]] inline float acos(float x) {
  const ArcsineParts p = arcsine_parts(std::fabs(static_cast<double>(x)));
  const double near_one = 2.0 * p.value;
  const double large = x < 0.0f ? 2.0 * kHalfPi - near_one : near_one;
  const double small = x < 0.0f ? kHalfPi + p.value : kHalfPi - p.value;
  return static_cast<float>(p.large ? large : small);
}

// Returns the arctangent of y / x for y, x >= 0, not both 0 and not both infinite: of their ratio
// up to tan(pi/8), between there and 1 by pi / 4 less the angle between, above by the complement.
[[nodiscard]] constexpr double first_quadrant_arctangent(double y, double x) {
  const bool steep = y > x;
  const double low = steep ? x : y;
  const double high = steep ? y : x;
  const bool middle = low > kTanEighthPi * high;
  const double t = (middle ? low - high : low) / (middle ? low + high : high);
  const double z = t * t;
  const double angle = t * (1.0 + z * polynomial(kAtanShort, z)) + (middle ? kQuarterPi : 0.0);
  return steep ? kHalfPi - angle : angle;
}

[[nodiscard]] constexpr float atan(float x) {
  const auto magnitude = std::bit_cast<float>(std::bit_cast<uint32_t>(x) & 0x7fffffffU);
  return with_sign(first_quadrant_arctangent(static_cast<double>(magnitude), 1.0), x);
}
[[nodiscard]] constexpr float atan2(float y, float x) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  double ay = static_cast<double>(std::bit_cast<float>(std::bit_cast<uint32_t>(y) & 0x7fffffffU));
  double ax = static_cast<double>(std::bit_cast<float>(std::bit_cast<uint32_t>(x) & 0x7fffffffU));
  const bool both_infinite = ay == kInfinite && ax == kInfinite;
  ay = both_infinite ? 1.0 : ay;
  ax = both_infinite || (ax == 0.0 && ay == 0.0) ? 1.0 : ax;
  const double angle = first_quadrant_arctangent(ay, ax);
  return with_sign(std::bit_cast<int32_t>(x) < 0 ? 2.0 * kHalfPi - angle : angle, y);
}

} // namespace kindling::elementary
