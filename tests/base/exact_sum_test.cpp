// Tests of exact sums against 128-bit integer arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/exact_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <thread>
#include <vector>

namespace kindling {
namespace {

__extension__ using Int128 = __int128;
using Sum = ExactSum<55, 40>;
using SmallSum = ExactSmallSum<28, 3>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Returns random numbers of magnitude 2^min_exponent to 2^max_exponent, with all mantissa bits in
// use.
std::vector<double> random_terms(size_t count, int min_exponent, int max_exponent, bool with_signs) {
  std::mt19937_64 random(5);
  std::vector<double> terms(count);
  for (double& x : terms) {
    const auto span = static_cast<uint64_t>(max_exponent - min_exponent);
    const int exponent = min_exponent + static_cast<int>(random() % span);
    x = std::ldexp(1.0 + static_cast<double>(random() >> 12) * 0x1p-52, exponent);
    if (with_signs && random() % 2 == 0) x = -x;
  }
  return terms;
}

// Expects the same record for any order of the terms and any split into partial sums.
template <typename AnySum>
void expect_order_independent(std::vector<double> terms) {
  AnySum whole;
  for (const double x : terms) whole.add(x);
  std::mt19937 random(9);
  for (int i = 0; i < 10; ++i) {
    std::shuffle(terms.begin(), terms.end(), random);
    AnySum parts[3];
    for (const double x : terms) parts[random() % 3].add(x);
    parts[1].add(parts[2]);
    parts[1].add(parts[0]);
    EXPECT_EQ(parts[1], whole);
  }
}

// The compiler's own conversion is the reference: numbers of all lengths, ties, and their
// neighbors.
TEST(ExactSum, NearestDoubleOfEveryLengthAndTie) {
  __extension__ using UInt128 = unsigned __int128;
  std::mt19937_64 random(5);
  const auto check = [](UInt128 bits) {
    const double expected = static_cast<double>(static_cast<Int128>(bits));
    ASSERT_EQ(nearest_double(static_cast<uint64_t>(bits), static_cast<uint64_t>(bits >> 64)), expected);
  };
  for (int i = 0; i < 200000; ++i) {
    const UInt128 any = (static_cast<UInt128>(random()) << 64 | random()) >> (random() % 128);
    const int shift = static_cast<int>(random() % 74);
    const UInt128 tie = static_cast<UInt128>((random() >> 11) * 2 + 1) << shift; // 54 bits, the last one set
    for (const UInt128 bits : {any, ~any, tie, tie + 1, tie - 1, ~tie + 1}) check(bits);
  }
  for (int shift = 0; shift < 128; ++shift) check(static_cast<UInt128>(1) << shift);
  check(0);
  check(~static_cast<UInt128>(0));
}

TEST(ExactSum, IsIndependentOfOrder) {
  expect_order_independent<Sum>(random_terms(2000, -70, 40, true));
  expect_order_independent<ExactSum<64, 52, 11>>(random_terms(2000, -80, 52, true));
  expect_order_independent<SmallSum>(random_terms(2000, -40, 3, true));
  expect_order_independent<ExactSquareSum>(random_terms(2000, -100, 80, false));
}

// Returns x in multiples of 2^-kFractionBits, rounded to nearest; a long double is precise enough.
template <int kFractionBits>
Int128 rounded(double x) {
  return static_cast<Int128>(std::nearbyint(std::ldexp(static_cast<long double>(x), kFractionBits)));
}

template <int kFractionBits, int kRangeBits, int kCountBits>
void expect_exact() {
  // Some terms are below the unit, and below half of it.
  const std::vector<double> terms = random_terms(5000, -kFractionBits - 5, kRangeBits, true);
  ExactSum<kFractionBits, kRangeBits, kCountBits> sum;
  Int128 exact = 0;
  for (const double x : terms) {
    sum.add(x);
    exact += rounded<kFractionBits>(x);
    ASSERT_EQ(sum.value(), std::ldexp(static_cast<double>(exact), -kFractionBits)) << x;
  }
}

TEST(ExactSum, EqualsSumOfRoundedTerms) {
  expect_exact<55, 40, 32>();
  expect_exact<64, 52, 11>();
  SmallSum sum;
  Int128 exact = 0;
  for (const double x : random_terms(5000, -33, 3, true)) {
    sum.add(x);
    exact += rounded<28>(x);
    ASSERT_EQ(sum.value(), static_cast<double>(exact) * 0x1p-28) << x;
  }
}

TEST(ExactSum, TiesGoToEven) {
  for (const auto& [units, expected] : {std::pair{0.5, 0.0}, {1.5, 2.0}, {2.5, 2.0}, {-0.5, 0.0}, {-1.5, -2.0}}) {
    Sum sum;
    sum.add(units * 0x1p-55);
    EXPECT_EQ(sum.value(), expected * 0x1p-55) << units;
  }
}

TEST(ExactSum, KeepsSmallTermsBesideLargeOnes) {
  Sum sum;
  sum.add(0x1p-55);
  sum.add(0x1p40);
  sum.add(-0x1p40);
  EXPECT_EQ(sum.value(), 0x1p-55); // a sum in double precision would be 0
}

TEST(ExactSum, SubtractionInvertsAddition) {
  Sum part, sum;
  for (const double x : random_terms(100, -60, 40, true)) {
    part.add(x);
    sum.add(x);
  }
  sum.add(0.25);
  sum.subtract(part);
  EXPECT_EQ(sum.value(), 0.25);
}

template <typename AnySum>
AnySum sum_of(double x) {
  AnySum sum;
  sum.add(x);
  return sum;
}

TEST(ExactSum, TermsAreClamped) {
  for (const double x : {0x1.0000000000001p40, 0x1p41, 1e300, kInfinite}) {
    EXPECT_EQ(sum_of<Sum>(x).value(), 0x1p40) << x;
    EXPECT_EQ(sum_of<Sum>(-x).value(), -0x1p40) << x;
    EXPECT_FALSE(Sum::holds(x));
    EXPECT_EQ(sum_of<SmallSum>(x).value(), 8.0) << x;
    EXPECT_EQ(sum_of<SmallSum>(-x).value(), -8.0) << x;
  }
  EXPECT_EQ(sum_of<Sum>(0x1p40).value(), 0x1p40);
  for (const double x : {0x1.0000000000001p80, 1e300, kInfinite})
    EXPECT_EQ(sum_of<ExactSquareSum>(x).value(), 0x1p80) << x;
  EXPECT_EQ(sum_of<ExactSquareSum>(-1.0).value(), 0.0);
}

TEST(ExactSum, NanCountsAsZero) {
  EXPECT_EQ(sum_of<Sum>(kNan).value(), 0.0);
  EXPECT_EQ(sum_of<SmallSum>(kNan).value(), 0.0);
  EXPECT_EQ(sum_of<ExactSquareSum>(kNan).value(), 0.0);
  EXPECT_FALSE(Sum::holds(kNan));
}

// Sums 2^count_bits - 1 terms of the maximum magnitude, by doubling.
template <typename AnySum>
void expect_room(int count_bits, double max_term) {
  AnySum sum;
  for (int i = 0; i < count_bits; ++i) {
    const AnySum copy = sum;
    sum.add(copy);
    sum.add(max_term);
  }
  EXPECT_EQ(sum.value(), (std::ldexp(1.0, count_bits) - 1.0) * max_term);
}

TEST(ExactSum, DoesNotOverflowWithMaxTerms) {
  expect_room<Sum>(32, 0x1p40);
  expect_room<Sum>(32, -0x1p40);
  expect_room<ExactSum<64, 52, 11>>(11, -0x1p52);
  expect_room<SmallSum>(32, 8.0);
  expect_room<SmallSum>(32, -8.0);
  expect_room<ExactSquareSum>(32, 0x1p80);
}

// The expected sum has two exact parts: multiples of 2^20 and the remainders.
TEST(ExactSquareSum, EqualsSumOfTruncatedTerms) {
  for (const int largest : {-60, -20, -10, 0, 20, 45, 80}) { // carries from each word to the next
    ExactSquareSum sum;
    Int128 high = 0, low = 0; // in units of 2^20 and of 2^-80
    for (const double x : random_terms(3000, std::max(largest - 60, -90), largest, false)) {
      sum.add(x);
      const double coarse = std::floor(x * 0x1p-20);
      high += static_cast<Int128>(static_cast<long double>(coarse));
      low += static_cast<Int128>(std::ldexp(static_cast<long double>(x - coarse * 0x1p20), 80));
      const long double exact =
          static_cast<long double>(high) * 0x1p20L + std::ldexp(static_cast<long double>(low), -80);
      ASSERT_NEAR(sum.value(), static_cast<double>(exact), 0x1p-51 * static_cast<double>(exact)) << x;
    }
    EXPECT_GT(sum.value(), 0.0);
  }
}

// All terms, in any order and by several threads, give one sum.
TEST(ExactSum, SeveralThreadsAddToOneSum) {
  using LargeSum = ExactSum<64, 52, 11>;
  LargeSum plain, shared;
  std::vector<double> terms;
  std::mt19937 random(7);
  for (int i = 0; i < 40000; ++i) {
    const uint32_t bits = random();
    const double size = std::ldexp(static_cast<double>(bits), -40 + static_cast<int>(bits % 60));
    terms.push_back((bits & 64U) != 0 ? size : -size);
  }
  for (const double term : terms) plain.add(term);
  {
    std::vector<std::jthread> threads;
    for (size_t t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (size_t i = t; i < terms.size(); i += 4) shared.add_atomically(terms[i]);
      });
  }
  EXPECT_EQ(shared, plain);
}

} // namespace
} // namespace kindling
