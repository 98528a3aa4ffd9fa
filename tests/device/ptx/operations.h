// PTX instructions, a function for each: add.rn.f32 is add_rn_f32().
//
// By NVIDIA's "PTX ISA" 8.5; comments name its sections. translate_ptx.py reads the lines that
// begin with OP: they are the instructions that it knows, with the types of their operands.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/device/ptx/registers.h"

#include <cmath>

namespace ptx {

#define OP [[gnu::always_inline]] inline

// 9.7.1, integers. Registers are unsigned; instructions decide on the sign. Division by zero has
// no value, so it is an error.
OP u16 add_s16(u16 a, u16 b) { return static_cast<u16>(a + b); }
OP u32 add_s32(u32 a, u32 b) { return a + b; }
OP u64 add_s64(u64 a, u64 b) { return a + b; }
OP u64 add_u64(u64 a, u64 b) { return a + b; }
OP u16 sub_s16(u16 a, u16 b) { return static_cast<u16>(a - b); }
OP u32 sub_s32(u32 a, u32 b) { return a - b; }
OP u64 sub_s64(u64 a, u64 b) { return a - b; }
OP u16 mul_lo_s16(u16 a, u16 b) { return static_cast<u16>(u32{a} * b); }
OP u32 mul_lo_s32(u32 a, u32 b) { return a * b; }
OP u64 mul_lo_s64(u64 a, u64 b) { return a * b; }
OP u32 mul_wide_u16(u16 a, u16 b) { return u32{a} * b; }
OP u64 mul_wide_u32(u32 a, u32 b) { return u64{a} * b; }
OP u32 mul_wide_s16(u16 a, u16 b) { return static_cast<u32>(i32{i16(a)} * i16(b)); }
OP u64 mul_wide_s32(u32 a, u32 b) { return static_cast<u64>(i64{i32(a)} * i32(b)); }
OP u32 mul_hi_u32(u32 a, u32 b) { return static_cast<u32>(u64{a} * b >> 32); }
OP u64 mul_hi_u64(u64 a, u64 b) { return static_cast<u64>(u128{a} * b >> 64); }
OP u32 mul_hi_s32(u32 a, u32 b) { return static_cast<u32>(i64{i32(a)} * i32(b) >> 32); }
OP u32 mad_lo_s32(u32 a, u32 b, u32 c) { return a * b + c; }
OP u64 mad_lo_s64(u64 a, u64 b, u64 c) { return a * b + c; }
OP u32 div_u32(u32 a, u32 b) { return a / divisor(b); }
OP u64 div_u64(u64 a, u64 b) { return a / divisor(b); }
OP u32 div_s32(u32 a, u32 b) { return b == ~u32{0} ? 0 - a : static_cast<u32>(i32(a) / i32(divisor(b))); }
OP u64 div_s64(u64 a, u64 b) { return b == ~u64{0} ? 0 - a : static_cast<u64>(i64(a) / i64(divisor(b))); }
OP u32 rem_u32(u32 a, u32 b) { return a % divisor(b); }
OP u64 rem_u64(u64 a, u64 b) { return a % divisor(b); }
OP u32 rem_s32(u32 a, u32 b) { return b == ~u32{0} ? 0 : static_cast<u32>(i32(a) % i32(divisor(b))); }
OP u64 rem_s64(u64 a, u64 b) { return b == ~u64{0} ? 0 : static_cast<u64>(i64(a) % i64(divisor(b))); }
OP u32 neg_s32(u32 a) { return 0 - a; }
OP u64 neg_s64(u64 a) { return 0 - a; }
OP u32 abs_s32(u32 a) { return i32(a) < 0 ? 0 - a : a; }
OP u64 abs_s64(u64 a) { return i64(a) < 0 ? 0 - a : a; }
OP u16 min_u16(u16 a, u16 b) { return a < b ? a : b; }
OP u32 min_u32(u32 a, u32 b) { return a < b ? a : b; }
OP u64 min_u64(u64 a, u64 b) { return a < b ? a : b; }
OP u16 min_s16(u16 a, u16 b) { return i16(a) < i16(b) ? a : b; }
OP u32 min_s32(u32 a, u32 b) { return i32(a) < i32(b) ? a : b; }
OP u64 min_s64(u64 a, u64 b) { return i64(a) < i64(b) ? a : b; }
OP u16 max_u16(u16 a, u16 b) { return a < b ? b : a; }
OP u32 max_u32(u32 a, u32 b) { return a < b ? b : a; }
OP u64 max_u64(u64 a, u64 b) { return a < b ? b : a; }
OP u16 max_s16(u16 a, u16 b) { return i16(a) < i16(b) ? b : a; }
OP u32 max_s32(u32 a, u32 b) { return i32(a) < i32(b) ? b : a; }
OP u64 max_s64(u64 a, u64 b) { return i64(a) < i64(b) ? b : a; }
OP u32 popc_b32(u32 a) { return static_cast<u32>(__builtin_popcount(a)); }
OP u32 popc_b64(u64 a) { return static_cast<u32>(__builtin_popcountll(a)); }
OP u32 clz_b32(u32 a) { return a == 0 ? 32 : static_cast<u32>(__builtin_clz(a)); }
OP u32 clz_b64(u64 a) { return a == 0 ? 64 : static_cast<u32>(__builtin_clzll(a)); }
OP u32 brev_b32(u32 a) { return reversed(a); }
OP u64 brev_b64(u64 a) { return u64{reversed(static_cast<u32>(a))} << 32 | reversed(static_cast<u32>(a >> 32)); }
// Position and length are taken modulo 256.
OP u32 bfe_u32(u32 a, u32 at, u32 bits) { return static_cast<u32>(field(a, at & 255, bits & 255)); }
OP u32 bfi_b32(u32 a, u32 b, u32 at, u32 bits) { return inserted(a, b, at & 255, bits & 255); }

// 9.7.2, carry and borrow, which are no register.
OP u64 add_cc_s64(u64 a, u64 b, bool& carry) { return add_with_carry(a, b, false, carry); }
OP u64 addc_cc_s64(u64 a, u64 b, bool& carry) { return add_with_carry(a, b, carry, carry); }
OP u64 addc_s64(u64 a, u64 b, bool& carry) { return a + b + (carry ? 1 : 0); }
OP u64 sub_cc_s64(u64 a, u64 b, bool& carry) { return subtract_with_borrow(a, b, false, carry); }
OP u64 subc_cc_s64(u64 a, u64 b, bool& carry) { return subtract_with_borrow(a, b, carry, carry); }

// 9.7.3, floating point. rcp.rn is 1 / a, rounded once.
OP f32 add_rn_f32(f32 a, f32 b) { return with_nan(a + b); }
OP f32 sub_rn_f32(f32 a, f32 b) { return with_nan(a - b); }
OP f32 mul_rn_f32(f32 a, f32 b) { return with_nan(a * b); }
OP f32 fma_rn_f32(f32 a, f32 b, f32 c) { return with_nan(std::fma(a, b, c)); }
OP f32 div_rn_f32(f32 a, f32 b) { return with_nan(a / b); }
OP f32 rcp_rn_f32(f32 a) { return with_nan(1.0f / a); }
OP f32 sqrt_rn_f32(f32 a) { return with_nan(std::sqrt(a)); }
OP f64 add_rn_f64(f64 a, f64 b) { return a + b; }
OP f64 sub_rn_f64(f64 a, f64 b) { return a - b; }
OP f64 mul_rn_f64(f64 a, f64 b) { return a * b; }
OP f64 fma_rn_f64(f64 a, f64 b, f64 c) { return std::fma(a, b, c); }
OP f64 div_rn_f64(f64 a, f64 b) { return a / b; }
OP f64 rcp_rn_f64(f64 a) { return 1.0 / a; }
OP f64 sqrt_rn_f64(f64 a) { return std::sqrt(a); }
OP f32 neg_f32(f32 a) { return with_nan(-a); }
OP f64 neg_f64(f64 a) { return -a; }
OP f32 abs_f32(f32 a) { return with_nan(std::fabs(a)); }
OP f64 abs_f64(f64 a) { return std::fabs(a); }
// The number where one is NaN; -0 is less than +0.
OP f32 min_f32(f32 a, f32 b) { return smaller(a, b); }
OP f64 min_f64(f64 a, f64 b) { return smaller(a, b); }
OP f32 max_f32(f32 a, f32 b) { return larger(a, b); }
OP f64 max_f64(f64 a, f64 b) { return larger(a, b); }

// 9.7.6, comparisons. Those of floating point are false for NaN, or true where their name ends with
// u; ne is false, too.
OP bool setp_eq_b16(u16 a, u16 b) { return a == b; }
OP bool setp_eq_s16(u16 a, u16 b) { return a == b; }
OP bool setp_ne_b16(u16 a, u16 b) { return a != b; }
OP bool setp_ne_s16(u16 a, u16 b) { return a != b; }
OP bool setp_lt_u16(u16 a, u16 b) { return a < b; }
OP bool setp_le_u16(u16 a, u16 b) { return a <= b; }
OP bool setp_gt_u16(u16 a, u16 b) { return a > b; }
OP bool setp_ge_u16(u16 a, u16 b) { return a >= b; }
OP bool setp_lt_s16(u16 a, u16 b) { return i16(a) < i16(b); }
OP bool setp_le_s16(u16 a, u16 b) { return i16(a) <= i16(b); }
OP bool setp_gt_s16(u16 a, u16 b) { return i16(a) > i16(b); }
OP bool setp_ge_s16(u16 a, u16 b) { return i16(a) >= i16(b); }
OP bool setp_eq_b32(u32 a, u32 b) { return a == b; }
OP bool setp_eq_s32(u32 a, u32 b) { return a == b; }
OP bool setp_ne_b32(u32 a, u32 b) { return a != b; }
OP bool setp_ne_s32(u32 a, u32 b) { return a != b; }
OP bool setp_lt_u32(u32 a, u32 b) { return a < b; }
OP bool setp_le_u32(u32 a, u32 b) { return a <= b; }
OP bool setp_gt_u32(u32 a, u32 b) { return a > b; }
OP bool setp_ge_u32(u32 a, u32 b) { return a >= b; }
OP bool setp_lt_s32(u32 a, u32 b) { return i32(a) < i32(b); }
OP bool setp_le_s32(u32 a, u32 b) { return i32(a) <= i32(b); }
OP bool setp_gt_s32(u32 a, u32 b) { return i32(a) > i32(b); }
OP bool setp_ge_s32(u32 a, u32 b) { return i32(a) >= i32(b); }
OP bool setp_eq_b64(u64 a, u64 b) { return a == b; }
OP bool setp_eq_s64(u64 a, u64 b) { return a == b; }
OP bool setp_ne_b64(u64 a, u64 b) { return a != b; }
OP bool setp_ne_s64(u64 a, u64 b) { return a != b; }
OP bool setp_lt_u64(u64 a, u64 b) { return a < b; }
OP bool setp_le_u64(u64 a, u64 b) { return a <= b; }
OP bool setp_gt_u64(u64 a, u64 b) { return a > b; }
OP bool setp_ge_u64(u64 a, u64 b) { return a >= b; }
OP bool setp_lt_s64(u64 a, u64 b) { return i64(a) < i64(b); }
OP bool setp_le_s64(u64 a, u64 b) { return i64(a) <= i64(b); }
OP bool setp_gt_s64(u64 a, u64 b) { return i64(a) > i64(b); }
OP bool setp_ge_s64(u64 a, u64 b) { return i64(a) >= i64(b); }
OP bool setp_eq_f32(f32 a, f32 b) { return a == b; }
OP bool setp_ne_f32(f32 a, f32 b) { return a < b || a > b; }
OP bool setp_lt_f32(f32 a, f32 b) { return a < b; }
OP bool setp_le_f32(f32 a, f32 b) { return a <= b; }
OP bool setp_gt_f32(f32 a, f32 b) { return a > b; }
OP bool setp_ge_f32(f32 a, f32 b) { return a >= b; }
OP bool setp_equ_f32(f32 a, f32 b) { return !(a < b || a > b); }
OP bool setp_neu_f32(f32 a, f32 b) { return !(a == b); }
OP bool setp_ltu_f32(f32 a, f32 b) { return !(a >= b); }
OP bool setp_leu_f32(f32 a, f32 b) { return !(a > b); }
OP bool setp_gtu_f32(f32 a, f32 b) { return !(a <= b); }
OP bool setp_geu_f32(f32 a, f32 b) { return !(a < b); }
OP bool setp_num_f32(f32 a, f32 b) { return a == a && b == b; }
OP bool setp_nan_f32(f32 a, f32 b) { return a != a || b != b; }
OP bool setp_eq_f64(f64 a, f64 b) { return a == b; }
OP bool setp_ne_f64(f64 a, f64 b) { return a < b || a > b; }
OP bool setp_lt_f64(f64 a, f64 b) { return a < b; }
OP bool setp_le_f64(f64 a, f64 b) { return a <= b; }
OP bool setp_gt_f64(f64 a, f64 b) { return a > b; }
OP bool setp_ge_f64(f64 a, f64 b) { return a >= b; }
OP bool setp_equ_f64(f64 a, f64 b) { return !(a < b || a > b); }
OP bool setp_neu_f64(f64 a, f64 b) { return !(a == b); }
OP bool setp_ltu_f64(f64 a, f64 b) { return !(a >= b); }
OP bool setp_leu_f64(f64 a, f64 b) { return !(a > b); }
OP bool setp_gtu_f64(f64 a, f64 b) { return !(a <= b); }
OP bool setp_geu_f64(f64 a, f64 b) { return !(a < b); }
OP bool setp_num_f64(f64 a, f64 b) { return a == a && b == b; }
OP bool setp_nan_f64(f64 a, f64 b) { return a != a || b != b; }
OP u16 selp_u16(u16 a, u16 b, bool c) { return c ? a : b; }
OP u16 selp_b16(u16 a, u16 b, bool c) { return c ? a : b; }
OP u32 selp_u32(u32 a, u32 b, bool c) { return c ? a : b; }
OP u32 selp_s32(u32 a, u32 b, bool c) { return c ? a : b; }
OP u32 selp_b32(u32 a, u32 b, bool c) { return c ? a : b; }
OP u64 selp_u64(u64 a, u64 b, bool c) { return c ? a : b; }
OP u64 selp_b64(u64 a, u64 b, bool c) { return c ? a : b; }
OP f32 selp_f32(f32 a, f32 b, bool c) { return c ? a : b; }
OP f64 selp_f64(f64 a, f64 b, bool c) { return c ? a : b; }

// 9.7.8, bits. Shifts by more than the width of a register are shifts by its width, unlike those of
// x86; a funnel shift that wraps takes the count modulo 32.
OP bool and_pred(bool a, bool b) { return a && b; }
OP u16 and_b16(u16 a, u16 b) { return a & b; }
OP u32 and_b32(u32 a, u32 b) { return a & b; }
OP u64 and_b64(u64 a, u64 b) { return a & b; }
OP bool or_pred(bool a, bool b) { return a || b; }
OP u16 or_b16(u16 a, u16 b) { return a | b; }
OP u32 or_b32(u32 a, u32 b) { return a | b; }
OP u64 or_b64(u64 a, u64 b) { return a | b; }
OP bool xor_pred(bool a, bool b) { return a != b; }
OP u16 xor_b16(u16 a, u16 b) { return a ^ b; }
OP u32 xor_b32(u32 a, u32 b) { return a ^ b; }
OP u64 xor_b64(u64 a, u64 b) { return a ^ b; }
OP bool not_pred(bool a) { return !a; }
OP u16 not_b16(u16 a) { return static_cast<u16>(~a); }
OP u32 not_b32(u32 a) { return ~a; }
OP u64 not_b64(u64 a) { return ~a; }
OP u16 shl_b16(u16 a, u32 n) { return n < 16 ? static_cast<u16>(a << n) : 0; }
OP u32 shl_b32(u32 a, u32 n) { return n < 32 ? a << n : 0; }
OP u64 shl_b64(u64 a, u32 n) { return n < 64 ? a << n : 0; }
OP u16 shr_u16(u16 a, u32 n) { return n < 16 ? static_cast<u16>(a >> n) : 0; }
OP u32 shr_u32(u32 a, u32 n) { return n < 32 ? a >> n : 0; }
OP u64 shr_u64(u64 a, u32 n) { return n < 64 ? a >> n : 0; }
OP u16 shr_s16(u16 a, u32 n) { return static_cast<u16>(i16(a) >> (n < 16 ? n : 15)); }
OP u32 shr_s32(u32 a, u32 n) { return static_cast<u32>(i32(a) >> (n < 32 ? n : 31)); }
OP u64 shr_s64(u64 a, u32 n) { return static_cast<u64>(i64(a) >> (n < 64 ? n : 63)); }
OP u32 shf_l_wrap_b32(u32 a, u32 b, u32 n) { return static_cast<u32>((u64{b} << 32 | a) << (n & 31) >> 32); }
OP u32 shf_r_wrap_b32(u32 a, u32 b, u32 n) { return static_cast<u32>((u64{b} << 32 | a) >> (n & 31)); }

// 9.7.13, votes and shuffles of a warp. Each thread is alone in its warp, as lane 0.
OP u32 activemask_b32() { return 1; }
OP u32 match_any_sync_b32(u32 /*a*/, u32 mask) { return mask; }
OP u32 shfl_sync_idx_b32(u32 a, u32 lane, u32 /*clamp*/, u32 /*mask*/) {
  if (lane != 0) fault("shfl reads a lane that is not in the warp");
  return a;
}

// 9.7.9, moves and conversions.
OP bool mov_pred(bool a) { return a; }
OP u16 mov_u16(u16 a) { return a; }
OP u16 mov_b16(u16 a) { return a; }
OP u32 mov_u32(u32 a) { return a; }
OP u32 mov_b32(u32 a) { return a; }
OP u64 mov_u64(u64 a) { return a; }
OP u64 mov_b64(u64 a) { return a; }
OP f32 mov_f32(f32 a) { return a; }
OP f64 mov_f64(f64 a) { return a; }
OP u32 cvt_u32_u8(u16 a) { return a & 0xffU; }
OP u32 cvt_u32_u16(u16 a) { return a; }
OP u64 cvt_u64_u16(u16 a) { return a; }
OP u64 cvt_u64_u32(u32 a) { return a; }
OP u64 cvt_s64_s32(u32 a) { return static_cast<u64>(i64{i32(a)}); }
OP u64 cvt_s64_s16(u16 a) { return static_cast<u64>(i64{i16(a)}); }
OP u32 cvt_s32_s16(u16 a) { return static_cast<u32>(i32{i16(a)}); }
OP u32 cvt_s32_s8(u16 a) { return static_cast<u32>(i32{i8(a)}); }
OP u16 cvt_s16_s8(u16 a) { return static_cast<u16>(i16{i8(a)}); }
OP u16 cvt_u16_u32(u32 a) { return static_cast<u16>(a); }
OP u16 cvt_u16_u64(u64 a) { return static_cast<u16>(a); }
OP u32 cvt_u32_u64(u64 a) { return static_cast<u32>(a); }
OP f32 cvt_rn_f32_u16(u16 a) { return a; }
OP f32 cvt_rn_f32_s16(u16 a) { return i16(a); }
OP f32 cvt_rn_f32_u32(u32 a) { return static_cast<f32>(a); }
OP f32 cvt_rn_f32_s32(u32 a) { return static_cast<f32>(i32(a)); }
OP f32 cvt_rn_f32_u64(u64 a) { return static_cast<f32>(a); }
OP f32 cvt_rn_f32_s64(u64 a) { return static_cast<f32>(i64(a)); }
OP f64 cvt_rn_f64_u32(u32 a) { return a; }
OP f64 cvt_rn_f64_s32(u32 a) { return i32(a); }
OP f64 cvt_rn_f64_u64(u64 a) { return static_cast<f64>(a); }
OP f64 cvt_rn_f64_s64(u64 a) { return static_cast<f64>(i64(a)); }
OP f32 cvt_rn_f32_f64(f64 a) { return with_nan(static_cast<f32>(a)); }
OP f64 cvt_f64_f32(f32 a) { return a; }
OP f32 cvt_f32_f16(u16 a) { return of_half(a); }
// To whole numbers: rmi rounds down, rpi up, rni to the nearest or even one, rzi to zero.
OP f32 cvt_rmi_f32_f32(f32 a) { return with_nan(std::floor(a)); }
OP f32 cvt_rpi_f32_f32(f32 a) { return with_nan(std::ceil(a)); }
OP f32 cvt_rni_f32_f32(f32 a) { return with_nan(std::nearbyint(a)); }
OP f32 cvt_rzi_f32_f32(f32 a) { return with_nan(std::trunc(a)); }
OP f64 cvt_rmi_f64_f64(f64 a) { return std::floor(a); }
OP f64 cvt_rpi_f64_f64(f64 a) { return std::ceil(a); }
OP f64 cvt_rni_f64_f64(f64 a) { return std::nearbyint(a); }
OP f64 cvt_rzi_f64_f64(f64 a) { return std::trunc(a); }
// Values out of range become the nearest one in it. NaN becomes 0, or 1 << 63 where one of both has
// 64 bits.
OP u16 cvt_rzi_s16_f32(f32 a) { return static_cast<u16>(clamped<i16>(a, 0)); }
OP u16 cvt_rzi_u16_f32(f32 a) { return clamped<u16>(a, 0); }
OP u32 cvt_rzi_s32_f32(f32 a) { return static_cast<u32>(clamped<i32>(a, 0)); }
OP u32 cvt_rzi_u32_f32(f32 a) { return clamped<u32>(a, 0); }
OP u64 cvt_rzi_s64_f32(f32 a) { return static_cast<u64>(clamped<i64>(a, u64{1} << 63)); }
OP u64 cvt_rzi_u64_f32(f32 a) { return clamped<u64>(a, u64{1} << 63); }
OP u32 cvt_rzi_s32_f64(f64 a) { return static_cast<u32>(clamped<i32>(a, u64{1} << 31)); }
OP u32 cvt_rzi_u32_f64(f64 a) { return clamped<u32>(a, u64{1} << 31); }
OP u64 cvt_rzi_s64_f64(f64 a) { return static_cast<u64>(clamped<i64>(a, u64{1} << 63)); }
OP u64 cvt_rzi_u64_f64(f64 a) { return clamped<u64>(a, u64{1} << 63); }
#undef OP

} // namespace ptx
