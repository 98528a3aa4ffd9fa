// Scoped flushing of denormal floating-point numbers to zero.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <xmmintrin.h>

namespace kindling {

// Flushes denormals to zero on the constructing thread for the lifetime of the object. An operation
// on denormals takes a hundred times as long as a normal one, and they are negligible as radiance.
class FlushDenormals {
 public:
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | kFlushToZero | kDenormalsAreZero); }
  ~FlushDenormals() { _mm_setcsr(saved_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  static constexpr unsigned kFlushToZero = 1U << 15;
  static constexpr unsigned kDenormalsAreZero = 1U << 6;
  unsigned saved_;
};

} // namespace kindling
