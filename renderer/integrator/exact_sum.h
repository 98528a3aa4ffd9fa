// Sums of floats that do not depend on the order of their terms.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <bit>
#include <cstdint>

namespace kindling {

// Fixed point: a multiple of 2^-64 in 128 bits, so additions are exact and may come in any order. What of a term is below 2^-64 is cut
// off. Terms must be below 2^52 in size, and fewer than 2^10 may come close to it: others make the sum not a number.
class ExactSum {
 public:
  void add(float x) {
    const auto bits = std::bit_cast<uint32_t>(x);
    const int exponent = static_cast<int>((bits >> 23) & 0xffU);
    if (exponent == 0) return; // zero, or far below the last bit
    const int shift = exponent - 150 + kFractionBits;
    if (shift > kMostShift) {
      sound_ = false;
      return;
    }
    const Int128 mantissa = static_cast<Int128>((bits & 0x7fffffU) | 0x800000U);
    const Int128 term = shift >= 0 ? mantissa << shift : shift > -24 ? mantissa >> -shift : 0;
    sum_ += (bits >> 31) != 0 ? -term : term;
  }
  [[nodiscard]] float value() const {
    return sound_ ? static_cast<float>(static_cast<double>(sum_) * 0x1p-64) : std::numeric_limits<float>::quiet_NaN();
  }

 private:
  __extension__ using Int128 = __int128;
  static constexpr int kFractionBits = 64;
  static constexpr int kMostShift = 52 - 24 + kFractionBits;

  Int128 sum_ = 0;
  bool sound_ = true;
};

struct ExactRgbSum {
  ExactSum r, g, b;
  void add(const Rgb& c) {
    r.add(c.x);
    g.add(c.y);
    b.add(c.z);
  }
  [[nodiscard]] Rgb value() const { return {r.value(), g.value(), b.value()}; }
};

} // namespace kindling
