// Scoped flushing of denormal floating-point numbers to zero.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace kindling {

// Flushes denormals to zero on the constructing thread for the lifetime of the object, as operands
// and as results. An operation on denormals takes a hundred times as long as a normal one on some
// processors, and they are negligible as radiance. On processors other than x86-64 and arm64 it
// does nothing.
class FlushDenormals {
 public:
  FlushDenormals() : saved_(control()) { set_control(saved_ | kFlush); }
  ~FlushDenormals() { set_control(saved_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
#if defined(__SSE__)
  // MXCSR: bit 15 flushes results, bit 6 operands (Intel SDM, volume 1, 10.2.3).
  using Control = unsigned;
  static constexpr Control kFlush = 1U << 15 | 1U << 6;
  static Control control() { return _mm_getcsr(); }
  static void set_control(Control value) { _mm_setcsr(value); }
#elif defined(__aarch64__)
  // FPCR: bit 24 flushes both (Arm Architecture Reference Manual, FPCR.FZ).
  using Control = uint64_t;
  static constexpr Control kFlush = uint64_t{1} << 24;
  static Control control() {
    Control value;
    asm volatile("mrs %0, fpcr" : "=r"(value));
    return value;
  }
  static void set_control(Control value) { asm volatile("msr fpcr, %0" : : "r"(value)); }
#else
  using Control = unsigned;
  static constexpr Control kFlush = 0;
  static Control control() { return 0; }
  static void set_control(Control) {}
#endif

  Control saved_;
};

} // namespace kindling
