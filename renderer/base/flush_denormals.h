// Flushes denormal numbers to zero on this thread for as long as it lives: they cost a hundred times a normal operation, and
// light carries no information in them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <xmmintrin.h>

namespace kindling {

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
