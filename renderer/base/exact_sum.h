// Fixed-point sums whose results are independent of the order and the grouping of their terms.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/on_gpu.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace kindling {

// Each term is rounded to the nearest multiple of a unit (ties to even) and clamped to a maximum
// magnitude; NaN counts as 0. All further arithmetic is on integers and therefore associative. Each
// class holds 2^32 - 1 terms of the maximum magnitude. With more terms, or with invalid stored
// bits, a sum wraps around: the value is wrong, but the behavior is defined.
//
// All classes are plain records of 64-bit words, lowest word first, in two's complement.

// Rounds to nearest, ties to even; |x| < 2^63. std::llrint() is one instruction of processors, and
// missing on GPUs.
[[nodiscard]] inline int64_t round_to_int64(double x) {
#if KINDLING_ON_GPU
  return static_cast<int64_t>(__builtin_nearbyint(x));
#else
  return std::llrint(x);
#endif
}

// Returns the nearest double of a 128-bit number in two's complement, ties to even. GPUs have no
// conversion of that size.
[[nodiscard]] inline double nearest_double(uint64_t low, uint64_t high) {
  const bool negative = (high >> 63) != 0;
  if (negative) {
    low = ~low + 1;
    high = ~high + (low == 0 ? 1 : 0);
  }
  double magnitude = static_cast<double>(low);
  if (high != 0) {
    // The highest 64 bits, the last of which is set if any bit below them is: a double has
    // 53, so it is rounded as the whole number would be.
    const int above = std::countl_zero(high);
    const uint64_t top = above == 0 ? high : high << above | low >> (64 - above);
    const uint64_t rest = low << above;
    const double scale = std::bit_cast<double>(static_cast<uint64_t>(1023 + 64 - above) << 52); // 2^(64 - above)
    magnitude = static_cast<double>(top | (rest != 0 ? 1U : 0U)) * scale;
  }
  return negative ? -magnitude : magnitude;
}

// A signed 128-bit sum of terms within +-2^kRangeBits, in multiples of 2^-kFractionBits.
template <int kFractionBits, int kRangeBits, int kCountBits = 32>
class ExactSum {
 public:
  static constexpr double kLargestTerm = std::bit_cast<double>(static_cast<uint64_t>(1023 + kRangeBits) << 52);

  [[nodiscard]] static bool holds(double x) { return std::abs(x) <= kLargestTerm; }

  void add(double x) {
    if (std::abs(x) < kOneStep) [[likely]]
      add_bits(static_cast<UInt128>(static_cast<Int128>(round_to_int64(x * kFractionScale))));
    else
      add_large(x);
  }
  void add(const ExactSum& other) { add_bits(other.bits()); }
  // add() for several threads at once. A sum wraps at 2^64, and one thread sees it wrap.
  void add_atomically(double x) {
    ExactSum term;
    term.add(x);
    const uint64_t before = __atomic_fetch_add(&low_, term.low_, __ATOMIC_RELAXED);
    const uint64_t carry = before + term.low_ < before ? 1 : 0;
    __atomic_fetch_add(&high_, term.high_ + carry, __ATOMIC_RELAXED);
  }
  void subtract(const ExactSum& other) { add_bits(-other.bits()); }

  // Returns the nearest double.
  [[nodiscard]] double value() const { return nearest_double(low_, high_) * (1.0 / kFractionScale); }
  bool operator==(const ExactSum&) const = default;

 private:
  __extension__ using Int128 = __int128;
  __extension__ using UInt128 = unsigned __int128;

  static constexpr double power_of_2(int exponent) {
    return std::bit_cast<double>(static_cast<uint64_t>(1023 + exponent) << 52);
  }
  static constexpr double kFractionScale = power_of_2(kFractionBits);
  // Smaller terms, in units, fit the processor's conversion to 64 bits. Larger ones are added in
  // two steps: multiples of 2^-kCoarseBits, then the exact remainder, which is at most half of one
  // such multiple. Ties still go to even.
  static constexpr double kOneStep = power_of_2(63 - kFractionBits);
  static constexpr int kCoarseBits = 61 - kRangeBits < 8 ? 61 - kRangeBits : 8;
  static constexpr int kRestBits = kFractionBits - kCoarseBits;
  static constexpr double kCoarseScale = power_of_2(kCoarseBits);
  // (2^n - 1) 2^r 2^f < 2^127
  static_assert(kFractionBits + kRangeBits + kCountBits <= 127);
  static_assert(kRangeBits + kCoarseBits <= 62 && kRestBits > 0 && kRestBits <= 62);

  [[nodiscard]] UInt128 bits() const { return static_cast<UInt128>(high_) << 64 | low_; }
  // By words, in place: GCC takes a sum of 128 bits by way of the stack where registers are few.
  void add_bits(UInt128 term) {
    const bool carry = __builtin_add_overflow(low_, static_cast<uint64_t>(term), &low_);
    high_ += static_cast<uint64_t>(term >> 64) + (carry ? 1 : 0);
  }

  [[gnu::noinline]] void add_large(double x) {
    if (!holds(x)) x = x > 0.0 ? kLargestTerm : x < 0.0 ? -kLargestTerm : 0.0;
    const double coarse = std::nearbyint(x * kCoarseScale);
    const double rest = x - coarse * (1.0 / kCoarseScale);
    const auto term = static_cast<UInt128>(static_cast<Int128>(static_cast<int64_t>(coarse))) << kRestBits;
    add_bits(term + static_cast<UInt128>(static_cast<Int128>(round_to_int64(rest * kFractionScale))));
  }

  uint64_t low_ = 0;
  uint64_t high_ = 0;
};

// A signed 64-bit sum, for terms within a small known range.
template <int kFractionBits, int kRangeBits>
class ExactSmallSum {
 public:
  static constexpr double kLargestTerm = static_cast<double>(int64_t{1} << kRangeBits);

  void add(double x) {
    if (!(std::abs(x) <= kLargestTerm)) [[unlikely]]
      x = x > 0.0 ? kLargestTerm : x < 0.0 ? -kLargestTerm : 0.0;
    bits_ += static_cast<uint64_t>(round_to_int64(x * kFractionScale));
  }
  void add(const ExactSmallSum& other) { bits_ += other.bits_; }
  void subtract(const ExactSmallSum& other) { bits_ -= other.bits_; }

  [[nodiscard]] double value() const {
    return static_cast<double>(static_cast<int64_t>(bits_)) * (1.0 / kFractionScale);
  }
  bool operator==(const ExactSmallSum&) const = default;

 private:
  static constexpr double kFractionScale = static_cast<double>(int64_t{1} << kFractionBits);
  static_assert(kFractionBits + kRangeBits + 32 <= 63);

  uint64_t bits_ = 0;
};

// A 192-bit sum of terms in [0, 2^80], such as squares of the terms of an ExactSum<55, 40>, in
// multiples of 2^-80. Terms are truncated to a multiple; negative terms count as 0.
class ExactSquareSum {
 public:
  static constexpr double kLargestTerm = 0x1p80;

  void add(double x) {
    if (!(x >= 0x1p-80)) return;
    const auto bits = std::bit_cast<uint64_t>(std::min(x, kLargestTerm));
    const uint64_t mantissa = (bits & 0xfffffffffffffU) | uint64_t{1} << 52;
    // Left shift that brings the mantissa to its place: -52 to 108.
    const int shift = static_cast<int>(bits >> 52) - 1023 - 52 + kFractionBits;
    const UInt128 term = shift >= 0 ? static_cast<UInt128>(mantissa) << (shift % 64) : mantissa >> -shift;
    add_at(shift >= 64 ? 1 : 0, term);
  }
  void add(const ExactSquareSum& other) {
    add_at(0, static_cast<UInt128>(other.words_[1]) << 64 | other.words_[0]);
    words_[2] += other.words_[2];
  }

  [[nodiscard]] double value() const {
    return static_cast<double>(words_[2]) * 0x1p48 +
           static_cast<double>(static_cast<UInt128>(words_[1]) << 64 | words_[0]) * 0x1p-80;
  }
  bool operator==(const ExactSquareSum&) const = default;

 private:
  __extension__ using UInt128 = unsigned __int128;
  static constexpr int kFractionBits = 80;

  // Adds `term`, whose lowest word has index `first` (0 or 1).
  void add_at(int first, UInt128 term) {
    const auto add_word = [](uint64_t& word, uint64_t value) -> uint64_t {
      word += value;
      return word < value ? 1 : 0;
    };
    const auto low = static_cast<uint64_t>(term), high = static_cast<uint64_t>(term >> 64);
    const uint64_t carry = add_word(words_[first], low);
    uint64_t carry_high = add_word(words_[first + 1], high);
    carry_high += add_word(words_[first + 1], carry);
    if (first == 0) words_[2] += carry_high;
  }

  uint64_t words_[3] = {0, 0, 0};
};

} // namespace kindling
