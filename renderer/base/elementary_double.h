// Elementary functions of doubles that give the same bits on every machine and by every compiler.
//
// For what is computed once, while a scene is loaded or an image is written; elementary.h has those
// of hot loops and the rules of both. Errors are at most 1.05 units in the last place
// (tests/base/elementary_test.cpp compares them with the C library's long double).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/elementary.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace kindling::elementary {

// Returns c[0] + c[1] x + ... by Horner's scheme.
template <size_t kCount>
[[nodiscard]] constexpr double long_polynomial(const double (&c)[kCount], double x) {
  double result = c[kCount - 1];
  for (size_t i = kCount - 1; i-- > 0;) result = result * x + c[i];
  return result;
}

// Returns value times a power of two, rounded once; |power| < 1100.
[[nodiscard]] constexpr double times_power_of_two(double value, int power) {
  const int half = power / 2;
  const auto factor = [](int p) { return std::bit_cast<double>(static_cast<uint64_t>(p + 1023) << 52); };
  return value * factor(half) * factor(power - half);
}

// Returns 2^(t + low) for |low| much smaller than 1.
[[nodiscard]] constexpr double double_exp2(double t, double low) {
  if (t != t) return t;
  if (!(t > -1100.0)) return 0.0;
  if (!(t < 1100.0)) return std::numeric_limits<double>::infinity();
  const double whole = (t + kRounder) - kRounder;
  const double r = t - whole;
  const DoublePair first = exact_product(r, kLn2);
  const DoublePair sum = exact_sum(1.0, first.high);
  const double rest = sum.low + (first.low + r * r * long_polynomial(kExp2Long, r)); // 2^r is near sum.high + rest
  return times_power_of_two(sum.high + (rest + low * kLn2 * (sum.high + rest)), static_cast<int>(whole));
}

[[nodiscard]] constexpr double exp2(double x) { return double_exp2(x, 0.0); }

[[nodiscard]] constexpr double exp(double x) {
  if (x != x) return x;
  if (!(x > -760.0)) return 0.0;
  if (!(x < 760.0)) return std::numeric_limits<double>::infinity();
  const double whole = (x * kLog2E + kRounder) - kRounder;
  const double upper = x - whole * kLn2Upper; // exact
  const double lower = whole * kLn2Lower;
  const double r = upper - lower;
  const double rest = (upper - r) - lower;
  return times_power_of_two(1.0 + (r + (rest + r * r * long_polynomial(kExpLong, r))), static_cast<int>(whole));
}

// x = 2^exponent m, with m between sqrt(1/2) and sqrt(2).
struct Mantissa {
  double exponent;
  double m;
};
[[nodiscard]] constexpr Mantissa split_mantissa(double x) {
  const bool denormal = x < std::numeric_limits<double>::min();
  constexpr uint64_t kRootHalf = 0x3fe6a09e667f3bcd;
  const uint64_t u = std::bit_cast<uint64_t>(denormal ? x * 0x1p54 : x) - kRootHalf + (uint64_t{1024} << 52);
  const double exponent = static_cast<double>(static_cast<int>(u >> 52) - 1024 - (denormal ? 54 : 0));
  return {exponent, std::bit_cast<double>((u & 0x000fffffffffffff) + kRootHalf)};
}

// Returns true for positive, finite x, which the logarithms below need.
[[nodiscard]] constexpr bool has_logarithm(double x) { return x > 0.0 && x < std::numeric_limits<double>::infinity(); }
// Returns the logarithm of any other x.
[[nodiscard]] constexpr double special_logarithm(double x) {
  if (x == 0.0) return -std::numeric_limits<double>::infinity();
  return x > 0.0 ? x : std::numeric_limits<double>::quiet_NaN();
}

// With f = m - 1, log(m) = f - f^2 / 2 + s (f^2 / 2 + R), where s = f / (2 + f) needs no more
// digits than its product (Freely Distributable LIBM, 1993).
[[nodiscard]] constexpr double log(double x) {
  if (!has_logarithm(x)) return special_logarithm(x);
  const Mantissa p = split_mantissa(x);
  const double f = p.m - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  const double half_square = 0.5 * f * f;
  const double r = 2.0 * z * long_polynomial(kLogLong, z);
  return p.exponent * kLn2Upper - ((half_square - (s * (half_square + r) + p.exponent * kLn2Lower)) - f);
}

// Returns the base-2 logarithm of a positive, finite x with a relative error near 2^-64.
[[nodiscard]] constexpr DoublePair precise_log2(double x) {
  const Mantissa p = split_mantissa(x);
  // s = (m - 1) / (m + 1)
  const DoublePair ratio = quotient({p.m - 1.0, 0.0}, exact_sum(p.m, 1.0));
  const double s = ratio.high, s_low = ratio.low;
  // u = 1 + z / 3 + z^2 (1 / 5 + ...)
  const DoublePair z = exact_product(s, s);
  const double z_low = z.low + 2.0 * s * s_low;
  const DoublePair third = exact_product(kThird, z.high);
  const DoublePair u = exact_sum(1.0, third.high);
  const double u_low =
      u.low + (third.low + kThirdRest * z.high + kThird * z_low + z.high * z.high * long_polynomial(kLogRest, z.high));
  const DoublePair half = exact_product(s, u.high);
  const double half_low = half.low + (s * u_low + s_low * u.high);
  const DoublePair scaled = exact_product(half.high, 2.0 * kLog2E);
  const double scaled_low = scaled.low + 2.0 * (half.high * kLog2ERest + half_low * kLog2E);
  const DoublePair total = exact_sum(p.exponent, scaled.high);
  return exact_sum(total.high, total.low + scaled_low);
}

[[nodiscard]] constexpr double log2(double x) { return has_logarithm(x) ? precise_log2(x).high : special_logarithm(x); }

// Returns x^y for x >= 0 and any y.
[[nodiscard]] constexpr double power_of_magnitude(double x, double y) {
  if (!has_logarithm(x)) return double_exp2(y * special_logarithm(x), 0.0);
  const DoublePair l = precise_log2(x);
  y = y > 0x1p80 ? 0x1p80 : y < -0x1p80 ? -0x1p80 : y; // as good as infinite
  const DoublePair t = exact_product(y, l.high);
  return double_exp2(t.high, t.low + y * l.low);
}

// Returns x^y. Negative x have powers of integer y.
[[nodiscard]] constexpr double pow(double x, double y) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const bool y_infinite = y == kInfinite || y == -kInfinite;
  if (y == 0.0 || x == 1.0 || (x == -1.0 && y_infinite)) return 1.0;
  if (x != x || y != y) return x + y;
  const bool negative = std::bit_cast<uint64_t>(x) >> 63 != 0;
  const double result = power_of_magnitude(negative ? -x : x, y);
  if (!negative || y_infinite) return result;
  // All doubles from 2^53 on are even integers.
  const double magnitude = y < 0.0 ? -y : y;
  const auto whole = [](double v) { return v >= 0x1p52 || (v + 0x1p52) - 0x1p52 == v; };
  if (x < 0.0 && x > -kInfinite && !whole(magnitude)) return std::numeric_limits<double>::quiet_NaN();
  const bool odd = magnitude < 0x1p53 && whole(magnitude) && !whole(0.5 * magnitude);
  return odd ? -result : result;
}

[[nodiscard]] constexpr ReducedAngle reduce_angle(double x) {
  return x >= -kQuarterPi && x <= kQuarterPi ? ReducedAngle{x, 0.0, 0} : reduce_any_angle(x);
}

// Sine and cosine of a reduced angle, each a large part and a small one.
[[nodiscard]] constexpr DoublePair reduced_sine(const ReducedAngle& a) {
  const double z = a.high * a.high;
  return {a.high, a.high * z * long_polynomial(kSinLong, z) + (a.low - 0.5 * z * a.low)};
}
[[nodiscard]] constexpr DoublePair reduced_cosine(const ReducedAngle& a) {
  const double z = a.high * a.high;
  const double near_one = 1.0 - 0.5 * z;
  return {near_one, ((1.0 - near_one) - 0.5 * z) + (z * z * long_polynomial(kCosLong, z) - a.high * a.low)};
}

// Returns true where a function with f(x) = x + O(x^3) is x itself, zeros with their signs
// included.
[[nodiscard]] constexpr bool is_own_value(double x) { return x > -0x1p-27 && x < 0x1p-27; }

[[nodiscard]] constexpr double sin(double x) {
  if (is_own_value(x)) return x;
  const ReducedAngle a = reduce_angle(x);
  const DoublePair value = (a.quadrant & 1) != 0 ? reduced_cosine(a) : reduced_sine(a);
  const double sum = value.high + value.low;
  return (a.quadrant & 2) != 0 ? -sum : sum;
}
[[nodiscard]] constexpr double cos(double x) {
  const ReducedAngle a = reduce_angle(x);
  const DoublePair value = (a.quadrant & 1) != 0 ? reduced_sine(a) : reduced_cosine(a);
  const double sum = value.high + value.low;
  return ((a.quadrant + 1) & 2) != 0 ? -sum : sum;
}

[[nodiscard]] constexpr double tan(double x) {
  if (is_own_value(x)) return x;
  const ReducedAngle a = reduce_angle(x);
  const DoublePair sine = reduced_sine(a), cosine = reduced_cosine(a);
  const DoublePair s = exact_sum(sine.high, sine.low), c = exact_sum(cosine.high, cosine.low);
  const DoublePair tangent = (a.quadrant & 1) != 0 ? quotient({-c.high, -c.low}, s) : quotient(s, c);
  return tangent.high + tangent.low;
}

// The arcsine of a > 1/2 is pi / 2 - 2 (root + rest): of the sine of half the complement.
[[nodiscard]] inline DoublePair half_complement(double a) {
  const double z = 0.5 * (1.0 - a);
  const double root = std::sqrt(z);
  if (!(root > 0.0)) return {root, root}; // 0, or NaN beyond 1
  const DoublePair square = exact_product(root, root);
  const double root_rest = ((z - square.high) - square.low) / (root + root);
  return {root, root_rest + root * z * long_polynomial(kAsinLong, z)};
}

[[nodiscard]] inline double asin(double x) {
  if (is_own_value(x)) return x;
  const double a = std::fabs(x);
  if (a <= 0.5) return x + x * x * x * long_polynomial(kAsinLong, x * x);
  const DoublePair half = half_complement(a);
  const DoublePair angle = exact_sum(kHalfPi, -2.0 * half.high);
  return std::copysign(angle.high + (angle.low + (kHalfPiRest - 2.0 * half.low)), x);
}
[[nodiscard]] inline double acos(double x) {
  const double a = std::fabs(x);
  if (a <= 0.5) {
    const DoublePair angle = exact_sum(kHalfPi, -x);
    return angle.high + (angle.low + (kHalfPiRest - x * x * x * long_polynomial(kAsinLong, x * x)));
  }
  const DoublePair half = half_complement(a);
  if (x > 0.0) return 2.0 * (half.high + half.low);
  const DoublePair angle = exact_sum(2.0 * kHalfPi, -2.0 * half.high);
  return angle.high + (angle.low + 2.0 * (kHalfPiRest - half.low));
}

[[nodiscard]] inline double atan2(double y, double x) {
  if (x != x || y != y) return x + y;
  double ay = std::fabs(y), ax = std::fabs(x);
  if (std::isinf(ax) || std::isinf(ay)) { // only their ratio counts
    ax = std::isinf(ax) ? 1.0 : 0.0;
    ay = std::isinf(ay) ? 1.0 : 0.0;
  }
  if (ax == 0.0 && ay == 0.0) ax = 1.0;
  const bool steep = ay > ax;
  double low = steep ? ax : ay, high = steep ? ay : ax;
  // Keeps exact products within their range.
  const double scale = high > 0x1p500 ? 0x1p-500 : high < 0x1p-400 ? 0x1p500 : 1.0;
  low *= scale;
  high *= scale;
  const bool middle = low > kTanEighthPi * high;
  const DoublePair numerator = middle ? exact_sum(low, -high) : DoublePair{low, 0.0};
  const DoublePair denominator = middle ? exact_sum(low, high) : DoublePair{high, 0.0};
  const bool tiny = low < high * 0x1p-300;
  const DoublePair ratio = tiny ? DoublePair{low / high, 0.0} : quotient(numerator, denominator);
  const double t = ratio.high;
  const double z = t * t;
  const double rest = ratio.low + t * z * long_polynomial(kAtanLong, z);
  // The angle as a sum; its complements are rounded once.
  DoublePair angle = middle ? exact_sum(kQuarterPi, t) : DoublePair{t, 0.0};
  angle.low += middle ? kQuarterPiRest + rest : rest;
  if (steep) {
    const DoublePair complement = exact_sum(kHalfPi, -angle.high);
    angle = {complement.high, complement.low + (kHalfPiRest - angle.low)};
  }
  if (std::signbit(x)) {
    const DoublePair complement = exact_sum(2.0 * kHalfPi, -angle.high);
    angle = {complement.high, complement.low + (2.0 * kHalfPiRest - angle.low)};
  }
  return std::copysign(angle.high + angle.low, y);
}
[[nodiscard]] inline double atan(double x) { return is_own_value(x) ? x : atan2(x, 1.0); }

} // namespace kindling::elementary
