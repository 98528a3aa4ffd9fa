// Scoped arithmetic of IEEE 754: denormal numbers are kept and results rounded to nearest.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace kindling {

// Sets the constructing thread to the arithmetic that all results are defined by, for the lifetime
// of the object: rounding to nearest, denormal operands and results kept. It is the default of all
// processors, but a program that links Kindling may have flushed denormals or chosen another
// rounding, and new threads inherit that. README.md has the reasons. On processors other than
// x86-64 and arm64 it does nothing.
class StandardArithmetic {
 public:
  StandardArithmetic() : saved_(control()) { set_control(saved_ & ~kDepartures); }
  ~StandardArithmetic() { set_control(saved_); }
  StandardArithmetic(const StandardArithmetic&) = delete;
  StandardArithmetic& operator=(const StandardArithmetic&) = delete;

 private:
#if defined(__SSE__)
  // MXCSR: bit 15 flushes results, bit 6 operands, bits 13 and 14 choose the rounding (Intel SDM,
  // volume 1, 10.2.3).
  using Control = unsigned;
  static constexpr Control kDepartures = 1U << 15 | 1U << 6 | 3U << 13;
  static Control control() { return _mm_getcsr(); }
  static void set_control(Control value) { _mm_setcsr(value); }
#elif defined(__aarch64__)
  // FPCR: bit 24 flushes both, bit 19 those of half precision, bits 22 and 23 choose the rounding
  // (Arm Architecture Reference Manual, FPCR).
  using Control = uint64_t;
  static constexpr Control kDepartures = uint64_t{1} << 24 | uint64_t{1} << 19 | uint64_t{3} << 22;
  static Control control() {
    Control value;
    asm volatile("mrs %0, fpcr" : "=r"(value));
    return value;
  }
  static void set_control(Control value) { asm volatile("msr fpcr, %0" : : "r"(value)); }
#else
  using Control = unsigned;
  static constexpr Control kDepartures = 0;
  static Control control() { return 0; }
  static void set_control(Control) {}
#endif

  Control saved_;
};

} // namespace kindling
