// Errors of the elementary functions against more precise ones, and their special values.
//
// KINDLING_ALL_FLOATS=1 is the long form: all 2^32 floats for functions of one argument, 400
// million pairs for those of two and 60 million doubles (100 million pairs), otherwise every 4099th
// float, 2 million, 300,000 and 500,000.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/elementary.h"
#include "renderer/base/elementary_double.h"
#include "renderer/base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

namespace kindling {
namespace {

static_assert(std::numeric_limits<long double>::digits >= 64,
              "the reference for doubles needs more digits than theirs");

constexpr double kWrong = 1e9;

bool is_long_form() {
  const char* all = std::getenv("KINDLING_ALL_FLOATS");
  return all != nullptr && *all == '1';
}
// How many numbers are drawn for each that the short form draws.
int draws_for_one() { return is_long_form() ? 200 : 1; }

// Returns the error of `result` in units of the last place that the exact value has in T; kWrong
// for the wrong special value or the wrong sign of a zero. Beyond the largest number infinity is
// 2^e.
template <typename T, typename Exact>
double error_in_ulps(T result, Exact exact) {
  if (std::isnan(exact) || std::isnan(result)) return std::isnan(exact) && std::isnan(result) ? 0.0 : kWrong;
  if (exact == 0) return result == 0 && std::signbit(result) == std::signbit(exact) ? 0.0 : kWrong;
  if (std::isinf(exact)) return result == static_cast<T>(exact) ? 0.0 : kWrong;
  const Exact end = std::ldexp(Exact(1), std::numeric_limits<T>::max_exponent);
  const Exact bounded = std::clamp<Exact>(exact, -end, end);
  const Exact value = std::isinf(result) ? std::copysign(end, static_cast<Exact>(result)) : static_cast<Exact>(result);
  int exponent = 0;
  (void)std::frexp(bounded, &exponent);
  exponent = std::clamp(exponent, std::numeric_limits<T>::min_exponent, std::numeric_limits<T>::max_exponent);
  const Exact ulp = std::ldexp(Exact(1), exponent - std::numeric_limits<T>::digits);
  return static_cast<double>(std::fabs(value - bounded) / ulp);
}

// The largest error seen, and its arguments.
struct Worst {
  double error = 0.0;
  double x = 0.0;
  double y = 0.0;

  void add(double e, double at_x, double at_y = 0.0) {
    if (e > error) *this = {e, at_x, at_y};
  }
  void expect_at_most(double bound, const char* name) const {
    std::printf("%-6s %.4f units in the last place at (%a, %a)\n", name, error, x, y);
    EXPECT_LE(error, bound) << name << "(" << x << ", " << y << ")";
  }
};

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kSpecialFloats[] = {0.0f,           1.0f,
                                    2.0f,           3.0f,
                                    0.5f,           1.5f,
                                    2.5f,           0x1p-149f,
                                    0x1p-126f,      0x1p-127f,
                                    0x1p-24f,       0x1p-12f,
                                    0x1.fffffep-1f, 0x1.000002p0f,
                                    0x1p23f,        0x1.fffffep23f,
                                    0x1p24f,        0x1.000002p24f,
                                    8388607.5f,     0x1p20f,
                                    0x1.fffffep19f, 0x1.921fb6p0f,
                                    0x1.921fb6p1f,  88.7228394f,
                                    88.72284f,      103.972f,
                                    104.0f,         127.0f,
                                    128.0f,         149.0f,
                                    150.0f,         0x1.fffffep127f,
                                    kInf,           std::numeric_limits<float>::quiet_NaN()};

template <typename F, typename G>
Worst worst_float(const F& f, const G& exact) {
  Worst worst;
  const auto check = [&](float x) {
    const float result = f(x);
    const double value = exact(static_cast<double>(x));
    // A unit in the last place is more than 2^-24 of the value: most floats are no new maximum.
    if (std::fabs(static_cast<double>(result) - value) <= worst.error * 0x1p-24 * std::fabs(value)) return;
    worst.add(error_in_ulps<float>(result, value), static_cast<double>(x));
  };
  for (const float x : kSpecialFloats) {
    check(x);
    check(-x);
  }
  const uint64_t step = is_long_form() ? 1 : 4099;
  for (uint64_t bits = 0; bits < uint64_t{1} << 32; bits += step)
    check(std::bit_cast<float>(static_cast<uint32_t>(bits)));
  return worst;
}

// Expects function NAME of a float within BOUND units in the last place.
#define EXPECT_FLOAT_ERROR(NAME, BOUND)                                                                                \
  worst_float([](float x) { return elementary::NAME(x); }, [](double x) { return std::NAME(x); })                      \
      .expect_at_most(BOUND, #NAME)

// elementary.h states the largest of these bounds.
TEST(ElementaryFloat, ExponentialsAreNearTheExactValue) {
  EXPECT_FLOAT_ERROR(exp, 0.62);
  EXPECT_FLOAT_ERROR(exp2, 0.62);
}
TEST(ElementaryFloat, LogarithmsAreNearTheExactValue) {
  EXPECT_FLOAT_ERROR(log, 0.563);
  EXPECT_FLOAT_ERROR(log2, 0.581); // 0.5807 at 0x1.00ab0ap+0, of all floats
}
TEST(ElementaryFloat, CircularFunctionsAreNearTheExactValue) {
  EXPECT_FLOAT_ERROR(sin, 0.57);
  EXPECT_FLOAT_ERROR(cos, 0.57);
  EXPECT_FLOAT_ERROR(tan, 0.57);
}
TEST(ElementaryFloat, ArcFunctionsAreNearTheExactValue) {
  EXPECT_FLOAT_ERROR(asin, 0.51);
  EXPECT_FLOAT_ERROR(acos, 0.51);
  EXPECT_FLOAT_ERROR(atan, 0.51);
}

class Numbers {
 public:
  float any_float() { return std::bit_cast<float>(next()); }
  double any_double() {
    const uint64_t high = next();
    return std::bit_cast<double>(high << 32 | next());
  }
  double between(double low, double high) { return low + (high - low) * (static_cast<double>(next()) * 0x1p-32); }

 private:
  uint32_t next() { return hash_u32(count_++); }
  uint32_t count_ = 0;
};

TEST(ElementaryFloat, PowersAndAnglesOfVectorsAreNearTheExactValue) {
  Worst power, angle;
  const auto check = [&](float x, float y) {
    const auto dx = static_cast<double>(x), dy = static_cast<double>(y);
    // Powers beyond doubles would be 0 or infinite there: as good for floats.
    power.add(error_in_ulps<float>(elementary::pow(x, y), std::pow(dx, dy)), dx, dy);
    angle.add(error_in_ulps<float>(elementary::atan2(x, y), std::atan2(dx, dy)), dx, dy);
  };
  const auto check_drawn = [&](std::array<float, 2> pair) { check(pair[0], pair[1]); };
  for (const float x : kSpecialFloats)
    for (const float y : kSpecialFloats)
      for (const float sx : {1.0f, -1.0f})
        for (const float sy : {1.0f, -1.0f}) check(sx * x, sy * y);
  Numbers numbers;
  for (int i = 0; i < 400000 * draws_for_one(); ++i) {
    check_drawn({numbers.any_float(), numbers.any_float()});
    check_drawn({static_cast<float>(numbers.between(0.0, 1.0)), static_cast<float>(numbers.between(0.0, 20.0))});
    // Powers over the range of floats, near 1 as well.
    const float x = std::fabs(numbers.any_float());
    const float near_one = static_cast<float>(1.0 + numbers.between(-0.01, 0.01));
    for (const float base : {x, near_one}) {
      const double octaves = std::fabs(std::log2(static_cast<double>(base)));
      if (octaves > 0.0 && octaves < 1e9) check(base, static_cast<float>(numbers.between(-151.0, 129.0) / octaves));
    }
    check_drawn({-std::floor(static_cast<float>(numbers.between(1.0, 50.0))),
                 std::floor(static_cast<float>(numbers.between(-20.0, 20.0)))});
  }
  power.expect_at_most(0.62, "pow");
  angle.expect_at_most(0.51, "atan2");
}

constexpr double kSpecialDoubles[] = {0.0,
                                      1.0,
                                      2.0,
                                      3.0,
                                      0.5,
                                      1.5,
                                      2.5,
                                      0x1p-1074,
                                      0x1p-1022,
                                      0x1p-1023,
                                      0x1p-27,
                                      0x1p-53,
                                      0x1.fffffffffffffp-1,
                                      0x1.0000000000001p0,
                                      0x1p52,
                                      0x1.fffffffffffffp52,
                                      0x1p53,
                                      4503599627370495.5,
                                      0x1.921fb54442d18p-1,
                                      0x1.921fb54442d18p0,
                                      0x1.921fb54442d18p1,
                                      6381956970095103.0 * 0x1p797, // nearest to a multiple of pi / 2
                                      709.78,
                                      709.79,
                                      745.1,
                                      745.2,
                                      1023.0,
                                      1024.0,
                                      1074.0,
                                      1075.0,
                                      1e-300,
                                      1e300,
                                      std::numeric_limits<double>::max(),
                                      static_cast<double>(kInf),
                                      std::numeric_limits<double>::quiet_NaN()};

template <typename F, typename G>
Worst worst_double(const F& f, const G& exact, double low, double high) {
  Worst worst;
  const auto check = [&](double x) { worst.add(error_in_ulps<double>(f(x), exact(static_cast<long double>(x))), x); };
  for (const double x : kSpecialDoubles) {
    check(x);
    check(-x);
  }
  Numbers numbers;
  for (int i = 0; i < 100000 * draws_for_one(); ++i) {
    check(numbers.any_double());
    check(numbers.between(low, high));
    check(1.0 + numbers.between(-0.01, 0.01));
  }
  return worst;
}

#define EXPECT_DOUBLE_ERROR(NAME, LOW, HIGH)                                                                           \
  worst_double([](double x) { return elementary::NAME(x); }, [](long double x) { return std::NAME(x); }, LOW, HIGH)    \
      .expect_at_most(1.0, #NAME)

TEST(ElementaryDouble, FunctionsAreNearTheExactValue) {
  EXPECT_DOUBLE_ERROR(exp, -745.0, 710.0);
  EXPECT_DOUBLE_ERROR(exp2, -1075.0, 1024.0);
  EXPECT_DOUBLE_ERROR(log, 0.0, 10.0);
  EXPECT_DOUBLE_ERROR(log2, 0.0, 10.0);
  EXPECT_DOUBLE_ERROR(sin, -10.0, 10.0);
  EXPECT_DOUBLE_ERROR(cos, -10.0, 10.0);
  EXPECT_DOUBLE_ERROR(tan, -10.0, 10.0);
  EXPECT_DOUBLE_ERROR(asin, -1.0, 1.0);
  EXPECT_DOUBLE_ERROR(acos, -1.0, 1.0);
  EXPECT_DOUBLE_ERROR(atan, -5.0, 5.0);
}

TEST(ElementaryDouble, PowersAndAnglesOfVectorsAreNearTheExactValue) {
  Worst power, angle;
  const auto check = [&](double x, double y) {
    const auto lx = static_cast<long double>(x), ly = static_cast<long double>(y);
    power.add(error_in_ulps<double>(elementary::pow(x, y), std::pow(lx, ly)), x, y);
    angle.add(error_in_ulps<double>(elementary::atan2(x, y), std::atan2(lx, ly)), x, y);
  };
  const auto check_drawn = [&](std::array<double, 2> pair) { check(pair[0], pair[1]); };
  for (const double x : kSpecialDoubles)
    for (const double y : kSpecialDoubles)
      for (const double sx : {1.0, -1.0})
        for (const double sy : {1.0, -1.0}) check(sx * x, sy * y);
  Numbers numbers;
  for (int i = 0; i < 100000 * draws_for_one(); ++i) {
    check_drawn({numbers.any_double(), numbers.any_double()});
    check_drawn({numbers.between(0.0, 3.0), numbers.between(-10.0, 10.0)});
    const double x = std::fabs(numbers.any_double());
    const double near_one = 1.0 + numbers.between(-0.001, 0.001);
    for (const double base : {x, near_one}) {
      const double octaves = std::fabs(std::log2(base));
      if (octaves > 0.0 && octaves < 1e9) check(base, numbers.between(-1075.0, 1024.0) / octaves);
    }
    check_drawn({-std::floor(numbers.between(1.0, 50.0)), std::floor(numbers.between(-20.0, 20.0))});
  }
  power.expect_at_most(1.05, "pow"); // 1.0454 at (0x1.69c8f222c7001p+0, 0x1.bae34b1cb9e2p+10) of the long form
  angle.expect_at_most(1.0, "atan2");
}

} // namespace
} // namespace kindling
