// Elementary functions of floats that give the same bits on every machine and by every compiler.
//
// They use additions, products, quotients and square roots of doubles, which IEEE 754 defines to
// the last bit, and operations on bits: no C library, no fused multiply-add (sources must be
// compiled with -ffp-contract=off). Exponentials and logarithms look up one entry of a table each,
// of 512 bytes and 2 KB. Branches are for special values and huge angles only.
//
// Errors are at most 0.62 units in the last place over all floats (tests/base/elementary_test.cpp
// measures them). Special values are those of C's Annex F: signed zeros, infinities, NaN.
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

// Exponents beyond this give 0 or infinity as float, and below it no double overflows.
inline constexpr double kMaxExponent = 1000.0;

// Returns 2^t rounded once, for |t| <= kMaxExponent. With k, the multiple of 1/64 that is nearest
// to t, it is 2^k times a short polynomial in t - k (P. T. P. Tang 1989, "Table-driven
// implementation of the exponential function in IEEE floating-point arithmetic").
[[nodiscard]] constexpr float exp2_of_exponent(double t) {
  constexpr double kRounderOf64ths = kRounder / 64.0;
  const double rounded = t + kRounderOf64ths;
  const auto k = std::bit_cast<uint64_t>(rounded);
  const double r = t - (rounded - kRounderOf64ths);
  const auto scale = std::bit_cast<double>(kExp2Table[k % 64] + (k << 46));
  return static_cast<float>(((1.0 + kExp2Near[0] * r) + kExp2Near[1] * (r * r)) * scale);
}

// Returns 2^t rounded once. Special values replace the result in the end, so that loops become
// vector code.
[[nodiscard]] constexpr float float_exp2(double t) {
  float result = exp2_of_exponent(t);
  if (!(t <= kMaxExponent)) [[unlikely]]
    result = t > 0.0 ? std::numeric_limits<float>::infinity() : std::numeric_limits<float>::quiet_NaN();
  if (t < -kMaxExponent) [[unlikely]]
    result = 0.0f;
  return result;
}

[[nodiscard]] constexpr float exp2(float x) { return float_exp2(static_cast<double>(x)); }
[[nodiscard]] constexpr float exp(float x) { return float_exp2(static_cast<double>(x) * kLog2E); }

inline constexpr uint32_t kMinNormalBits = 0x00800000, kInfinityBits = 0x7f800000;

// Returns the bits of a positive, finite float, for denormal ones those of the float 2^149 times as
// large less 149 in the exponent, which may become negative. They are taken as integers, so that it
// does not matter whether the thread flushes denormals.
[[nodiscard]] constexpr uint32_t normalized_bits(uint32_t bits) {
  if (bits < kMinNormalBits) [[unlikely]]
    bits = std::bit_cast<uint32_t>(static_cast<float>(static_cast<int32_t>(bits))) - (149U << 23);
  return bits;
}

// log2(x) is near the sum of `middle` and the logarithm of 1 + r.
struct Log2Parts {
  double middle;
  double r;
};
// Splits x, given by its normalized_bits(), into 2^k m. The middle is k and the logarithm of that
// of m's interval, r the relative distance of m from there (P. T. P. Tang 1990, "Table-driven
// implementation of the logarithm function in IEEE floating-point arithmetic").
[[nodiscard]] constexpr Log2Parts split_logarithm(uint32_t bits) {
  const uint32_t above = bits - kMinMantissa;
  const uint32_t mantissa = bits - (above & 0xff800000U);
  const auto m = std::bit_cast<double>((uint64_t{mantissa} << 29) + (uint64_t{1023 - 127} << 52));
  const Log2Entry entry = kLog2Table[above >> 16 & 127];
  return {static_cast<double>(static_cast<int32_t>(above) >> 23) + entry.log2, m * entry.inverse - 1.0};
}

// Returns log2(x) times `factor`, rounded once.
[[nodiscard]] constexpr float logarithm(float x, double factor) {
  const auto bits = std::bit_cast<uint32_t>(x);
  const Log2Parts p = split_logarithm(normalized_bits(bits));
  const double rest = factor * kLog2Near[1] + (factor * kLog2Near[2]) * p.r;
  const double value = (p.middle * factor + (factor * kLog2Near[0]) * p.r) + (p.r * p.r) * rest;
  auto result = static_cast<float>(value);
  if (bits - 1U >= kInfinityBits - 1U) [[unlikely]] { // 0, negative, infinite or NaN
    const float edge = bits == kInfinityBits ? x : std::numeric_limits<float>::quiet_NaN();
    result = bits << 1 == 0 ? -std::numeric_limits<float>::infinity() : edge;
  }
  return result;
}
[[nodiscard]] constexpr float log(float x) { return logarithm(x, kLn2); }
[[nodiscard]] constexpr float log2(float x) { return logarithm(x, 1.0); }

// Returns log2(x) with a relative error below 2^-37, from its normalized_bits().
[[nodiscard]] constexpr double log2_for_power(uint32_t bits) {
  const Log2Parts p = split_logarithm(bits);
  const double r2 = p.r * p.r;
  const double rest = (kLog2Nearer[1] + kLog2Nearer[2] * p.r) + kLog2Nearer[3] * r2;
  return (p.middle + kLog2Nearer[0] * p.r) + r2 * rest;
}

// Returns x^y where one of them is zero, denormal, negative, infinite or NaN, or the power is far
// beyond the range of floats.
[[nodiscard]] constexpr float special_pow(float x, float y) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  const bool y_infinite = y == kInfinite || y == -kInfinite;
  if (y == 0.0f || x == 1.0f || (x == -1.0f && y_infinite)) return 1.0f;
  if (x != x || y != y) return std::numeric_limits<float>::quiet_NaN();
  const uint32_t bits = std::bit_cast<uint32_t>(x) & 0x7fffffffU;
  const auto base = std::bit_cast<float>(bits);
  const bool grows = (base > 1.0f) == (y > 0.0f);
  const bool is_limit = y_infinite || bits == 0 || base == kInfinite;
  const float limit = grows ? kInfinite : 0.0f;
  const float result = is_limit ? limit : float_exp2(static_cast<double>(y) * log2_for_power(normalized_bits(bits)));
  if (std::bit_cast<int32_t>(x) >= 0 || y_infinite) return result;
  // All floats from 2^24 on are even integers.
  const auto power = static_cast<double>(y);
  const auto whole = [](double v) { return (v + kRounder) - kRounder == v; };
  const bool large = !(power > -0x1p24 && power < 0x1p24);
  if (bits != 0 && base < kInfinite && !large && !whole(power)) return std::numeric_limits<float>::quiet_NaN();
  return !large && whole(power) && !whole(0.5 * power) ? -result : result;
}

// Returns x^y. Negative x have powers of integer y.
[[nodiscard]] constexpr float pow(float x, float y) {
  const auto bits = std::bit_cast<uint32_t>(x);
  if (bits - kMinNormalBits >= kInfinityBits - kMinNormalBits) [[unlikely]]
    return special_pow(x, y);
  const double exponent = static_cast<double>(y) * log2_for_power(bits);
  if (!(exponent * exponent <= kMaxExponent * kMaxExponent)) [[unlikely]]
    return special_pow(x, y);
  return exp2_of_exponent(exponent);
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
