// Order-independent sum of the terms of one sample's ray tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/exact_sum.h"
#include "renderer/base/math.h"

#include <cstdint>
#include <limits>

namespace kindling {

// Fixed point with a resolution of 2^-64. A term beyond 2^52 in size makes the sum not a number, so
// that the sample is dropped and counted as non-finite; there is room for 2^11 terms of that size.
class WhittedSum {
 public:
  void add(float x) {
    if (Sum::holds(static_cast<double>(x)))
      sum_.add(static_cast<double>(x));
    else
      sound_ = 0;
  }
  // The same for several threads at once.
  void add_atomically(float x) {
    if (Sum::holds(static_cast<double>(x)))
      sum_.add_atomically(static_cast<double>(x));
    else
      __atomic_store_n(&sound_, 0U, __ATOMIC_RELAXED);
  }
  [[nodiscard]] float value() const {
    return sound_ != 0 ? static_cast<float>(sum_.value()) : std::numeric_limits<float>::quiet_NaN();
  }

 private:
  using Sum = ExactSum<64, 52, 11>;
  Sum sum_;
  uint32_t sound_ = 1; // 0: not a number; a word, because GPUs store no bytes atomically
};

struct WhittedRgbSum {
  WhittedSum r, g, b;
  void add(const Rgb& c) {
    r.add(c.x);
    g.add(c.y);
    b.add(c.z);
  }
  void add_atomically(const Rgb& c) {
    r.add_atomically(c.x);
    g.add_atomically(c.y);
    b.add_atomically(c.z);
  }
  [[nodiscard]] Rgb value() const { return {r.value(), g.value(), b.value()}; }
};

} // namespace kindling
