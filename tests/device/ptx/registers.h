// Types of PTX's registers, and the parts of its operations.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

namespace ptx {

using u8 = uint8_t;
using u16 = uint16_t;
using u32 = uint32_t;
using u64 = uint64_t;
using u128 = unsigned __int128;
using i8 = int8_t;
using i16 = int16_t;
using i32 = int32_t;
using i64 = int64_t;
using f32 = float;
using f64 = double;

// What a GPU ends a launch with.
class Fault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
[[noreturn, gnu::cold, gnu::noinline]] inline void fault(const std::string& message) { throw Fault(message); }

constexpr u32 bits(f32 a) { return std::bit_cast<u32>(a); }
constexpr u64 bits(f64 a) { return std::bit_cast<u64>(a); }
constexpr f32 number(u32 a) { return std::bit_cast<f32>(a); }
constexpr f64 number(u64 a) { return std::bit_cast<f64>(a); }

// The one NaN that single-precision instructions of NVIDIA's GPUs return; x86 has another.
inline f32 with_nan(f32 a) { return a == a ? a : number(u32{0x7fffffff}); }
inline f64 with_nan(f64 a) { return a; }

template <typename T>
T divisor(T b) {
  if (b == 0) fault("division by zero");
  return b;
}
inline u32 reversed(u32 a) {
  u32 result = 0;
  for (u32 i = 0; i < 32; ++i) result |= (a >> i & 1) << (31 - i);
  return result;
}
constexpr u64 mask(u32 bits) { return bits < 64 ? (u64{1} << bits) - 1 : ~u64{0}; }
constexpr u64 field(u32 a, u32 at, u32 bits) { return at < 32 ? u64{a} >> at & mask(bits) : 0; }
constexpr u32 inserted(u32 a, u32 b, u32 at, u32 bits) {
  const u32 covered = at < 32 ? static_cast<u32>(mask(bits) << at) : 0;
  return at < 32 ? (b & ~covered) | (a << at & covered) : b;
}
inline u64 add_with_carry(u64 a, u64 b, bool in, bool& out) {
  const u128 sum = u128{a} + b + (in ? 1 : 0);
  out = sum >> 64 != 0;
  return static_cast<u64>(sum);
}
inline u64 subtract_with_borrow(u64 a, u64 b, bool in, bool& out) {
  const u128 taken = u128{b} + (in ? 1 : 0);
  out = a < taken;
  return static_cast<u64>(a - taken);
}
template <typename T>
T smaller(T a, T b) {
  if (a != a || b != b) return a == a ? a : b == b ? b : with_nan(a);
  return a < b || (a == b && std::signbit(a)) ? a : b;
}
template <typename T>
T larger(T a, T b) {
  if (a != a || b != b) return a == a ? a : b == b ? b : with_nan(a);
  return a > b || (a == b && !std::signbit(a)) ? a : b;
}
inline f32 of_half(u16 a) {
  const u32 sign = u32{a & 0x8000U} << 16, exponent = a >> 10 & 31, fraction = a & 1023;
  if (exponent == 31) return fraction == 0 ? number(sign | 0x7f800000) : number(u32{0x7fffffff});
  const f32 size =
      exponent == 0 ? static_cast<f32>(fraction) * 0x1p-24f : number((exponent + 112) << 23 | fraction << 13);
  return number(bits(size) | sign);
}
// `of_nan`: the bits of the result for NaN.
template <typename To, typename From>
To clamped(From a, u64 of_nan) {
  using Limits = std::numeric_limits<To>;
  if (a != a) return static_cast<To>(of_nan);
  if (a >= std::ldexp(From{1}, Limits::digits)) return Limits::max();
  if (a < static_cast<From>(Limits::min())) return Limits::min();
  return static_cast<To>(a);
}

} // namespace ptx
