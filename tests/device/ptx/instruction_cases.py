"""Instructions with their operands and their results, by the PTX ISA."""
# SPDX-License-Identifier: Apache-2.0
import struct


def f(value):
    """The bits of a number in single precision."""
    return struct.unpack("<I", struct.pack("<f", value))[0]


def d(value):
    """The bits of a number in double precision."""
    return struct.unpack("<Q", struct.pack("<d", value))[0]


INFINITY, NAN, OTHER_NAN = f(float("inf")), 0x7FFFFFFF, 0xFFC00001
NAN_64 = d(float("nan"))
MIN_32, MAX_32, MIN_64, MAX_64 = 1 << 31, (1 << 31) - 1, 1 << 63, (1 << 63) - 1

# By instruction: types of the result and the operands; then operands, with the result at the end.
CASES = {
    # 9.7.1, integers
    "add.s16": ("b16 b16 b16", [(0xFFFF, 2, 1)]),
    "mul.lo.s32": ("b32 b32 b32", [(0x10001, 0x10001, 0x20001), (2**32 - 3, 5, 2**32 - 15)]),
    "mul.wide.u32": ("b64 b32 b32", [(2**32 - 1, 2**32 - 1, (2**32 - 1) ** 2)]),
    "mul.wide.s32": ("b64 b32 b32", [(2**32 - 1, 5, 2**64 - 5)]),
    "mul.hi.u32": ("b32 b32 b32", [(MIN_32, 6, 3)]),
    "mul.hi.u64": ("b64 b64 b64", [(MIN_64, 6, 3)]),
    "mad.lo.s32": ("b32 b32 b32 b32", [(2**32 - 1, 7, 10, 3)]),
    "div.s32": ("b32 b32 b32", [(2**32 - 7, 2, 2**32 - 3), (MIN_32, 2**32 - 1, MIN_32)]),
    "div.u32": ("b32 b32 b32", [(2**32 - 7, 2, 2**31 - 4)]),
    "rem.u32": ("b32 b32 b32", [(2**32 - 1, 10, 5)]),
    "max.s32": ("b32 b32 b32", [(2**32 - 1, 1, 1)]),
    "min.u32": ("b32 b32 b32", [(2**32 - 1, 1, 1)]),
    "popc.b32": ("b32 b32", [(0xF0F, 8)]),
    "clz.b32": ("b32 b32", [(0, 32), (1, 31)]),
    "clz.b64": ("b32 b64", [(0, 64), (1, 63)]),
    "brev.b32": ("b32 b32", [(0x80000006, 0x60000001)]),
    "bfe.u32": ("b32 b32 b32 b32", [(0xABCD1234, 8, 8, 0x12), (0xABCD1234, 28, 8, 0xA), (0xABCD1234, 32, 8, 0), (0xABCD1234, 4, 40, 0xABCD123), (0xABCD1234, 4, 0, 0)]),
    "bfi.b32": ("b32 b32 b32 b32 b32", [(0xFF, 0, 8, 4, 0xF00), (0, 0xFFFFFFFF, 8, 8, 0xFFFF00FF), (0xFF, 5, 32, 8, 5), (0xFF, 5, 8, 0, 5)]),
    # 9.7.3, floating point
    "add.rn.f32": ("f32 f32 f32", [(f(1), f(2**-24), f(1)), (f(1), f(2**-23), f(1 + 2**-23)), (INFINITY, f(-float("inf")), NAN), (OTHER_NAN, f(1), NAN)]),
    "mul.rn.f32": ("f32 f32 f32", [(f(1 + 2**-12), f(1 + 2**-12), f(1 + 2**-11)), (f(2**-100), f(2**-49), 1), (f(0), INFINITY, NAN)]),
    "fma.rn.f32": ("f32 f32 f32 f32", [(f(1 + 2**-12), f(1 + 2**-12), f(-1 - 2**-11), f(2**-24))]),
    "div.rn.f32": ("f32 f32 f32", [(f(1), f(3), 0x3EAAAAAB), (f(1), f(-0.0), f(-float("inf"))), (f(0), f(0), NAN)]),
    "rcp.rn.f32": ("f32 f32", [(f(3), 0x3EAAAAAB)]),
    "sqrt.rn.f32": ("f32 f32", [(f(2), 0x3FB504F3), (f(-1), NAN), (f(-0.0), f(-0.0))]),
    "fma.rn.f64": ("f64 f64 f64 f64", [(d(1 + 2**-27), d(1 + 2**-27), d(-1 - 2**-26), d(2**-54))]),
    "div.rn.f64": ("f64 f64 f64", [(d(1), d(3), 0x3FD5555555555555)]),
    "neg.f32": ("f32 f32", [(f(0), f(-0.0)), (OTHER_NAN, NAN)]),
    "abs.f32": ("f32 f32", [(f(-2), f(2)), (f(-0.0), f(0))]),
    "min.f32": ("f32 f32 f32", [(NAN, f(1), f(1)), (f(1), OTHER_NAN, f(1)), (OTHER_NAN, OTHER_NAN, NAN), (f(0), f(-0.0), f(-0.0)), (f(-0.0), f(0), f(-0.0)), (f(-1), f(2), f(-1))]),
    "max.f32": ("f32 f32 f32", [(NAN, f(1), f(1)), (f(1), OTHER_NAN, f(1)), (OTHER_NAN, OTHER_NAN, NAN), (f(0), f(-0.0), f(0)), (f(-0.0), f(0), f(0)), (f(-1), f(2), f(2))]),
    # 9.7.6, comparisons
    "setp.eq.f32": ("pred f32 f32", [(f(0), f(-0.0), 1), (NAN, NAN, 0)]),
    "setp.ne.f32": ("pred f32 f32", [(f(1), f(2), 1), (f(1), f(1), 0), (NAN, f(1), 0)]),
    "setp.neu.f32": ("pred f32 f32", [(f(1), f(2), 1), (f(1), f(1), 0), (NAN, f(1), 1)]),
    "setp.equ.f32": ("pred f32 f32", [(f(1), f(2), 0), (f(1), f(1), 1), (NAN, f(1), 1)]),
    "setp.lt.f32": ("pred f32 f32", [(f(1), f(2), 1), (f(2), f(2), 0), (NAN, f(1), 0)]),
    "setp.ltu.f32": ("pred f32 f32", [(f(1), f(2), 1), (f(2), f(2), 0), (NAN, f(1), 1)]),
    "setp.leu.f32": ("pred f32 f32", [(f(2), f(2), 1), (f(3), f(2), 0), (f(1), NAN, 1)]),
    "setp.gtu.f32": ("pred f32 f32", [(f(2), f(2), 0), (f(3), f(2), 1), (f(1), NAN, 1)]),
    "setp.geu.f32": ("pred f32 f32", [(f(2), f(2), 1), (f(1), f(2), 0), (f(1), NAN, 1)]),
    "setp.num.f32": ("pred f32 f32", [(f(2), f(1), 1), (f(1), NAN, 0)]),
    "setp.nan.f32": ("pred f32 f32", [(f(2), f(1), 0), (f(1), NAN, 1)]),
    "setp.lt.s32": ("pred b32 b32", [(2**32 - 1, 0, 1)]),
    "setp.lt.u32": ("pred b32 b32", [(2**32 - 1, 0, 0)]),
    "setp.lt.s16": ("pred b16 b16", [(0xFFFF, 0, 1)]),
    "setp.gt.s64": ("pred b64 b64", [(2**64 - 1, 0, 0)]),
    # 9.7.8, bits: counts of the width and more
    "shl.b16": ("b16 b16 b32", [(1, 15, 1 << 15), (1, 16, 0), (3, 15, 1 << 15)]),
    "shl.b32": ("b32 b32 b32", [(3, 31, MIN_32), (1, 32, 0), (1, 33, 0), (1, 2**32 - 1, 0)]),
    "shl.b64": ("b64 b64 b32", [(1, 63, MIN_64), (1, 64, 0), (1, 65, 0)]),
    "shr.u16": ("b16 b16 b32", [(0x8000, 15, 1), (0x8000, 16, 0)]),
    "shr.u32": ("b32 b32 b32", [(MIN_32, 31, 1), (MIN_32, 32, 0), (MIN_32, 33, 0)]),
    "shr.u64": ("b64 b64 b32", [(MIN_64, 63, 1), (MIN_64, 64, 0)]),
    "shr.s32": ("b32 b32 b32", [(2**32 - 8, 1, 2**32 - 4), (2**32 - 8, 32, 2**32 - 1), (8, 33, 0)]),
    "shr.s64": ("b64 b64 b32", [(2**64 - 8, 1, 2**64 - 4), (2**64 - 8, 64, 2**64 - 1)]),
    "shf.l.wrap.b32": ("b32 b32 b32 b32", [(0x80000001, 0x80000001, 1, 3), (0x80000001, 0x80000001, 33, 3), (MIN_32, 2, 0, 2)]),
    "shf.r.wrap.b32": ("b32 b32 b32 b32", [(1, 1, 1, MIN_32), (6, 0, 33, 3)]),
    # 9.7.9, conversions
    "cvt.rzi.s32.f32": ("b32 f32", [(NAN, 0), (f(3e9), MAX_32), (f(-3e9), MIN_32), (f(-1.9), 2**32 - 1), (f(1.9), 1)]),
    "cvt.rzi.u32.f32": ("b32 f32", [(NAN, 0), (f(5e9), 2**32 - 1), (f(-5), 0), (f(-0.5), 0), (f(3e9), 3000000000)]),
    "cvt.rzi.u64.f32": ("b64 f32", [(NAN, MIN_64), (f(1e30), 2**64 - 1), (f(-1), 0), (f(2.0**40), 2**40)]),
    "cvt.rzi.s64.f64": ("b64 f64", [(NAN_64, MIN_64), (d(1e30), MAX_64), (d(-1e30), MIN_64), (d(-1.5), 2**64 - 1)]),
    "cvt.rzi.s16.f32": ("b16 f32", [(f(40000), 32767), (f(-40000), 32768), (f(-2.5), 0xFFFE)]),
    "cvt.rni.f32.f32": ("f32 f32", [(f(2.5), f(2)), (f(3.5), f(4)), (f(-0.5), f(-0.0)), (OTHER_NAN, NAN)]),
    "cvt.rmi.f32.f32": ("f32 f32", [(f(-1.5), f(-2)), (f(1.5), f(1))]),
    "cvt.rpi.f32.f32": ("f32 f32", [(f(-1.5), f(-1)), (f(1.5), f(2))]),
    "cvt.rni.f64.f64": ("f64 f64", [(d(2.5), d(2)), (d(2.0**53 - 1), d(2.0**53 - 1))]),
    "cvt.rn.f32.u32": ("f32 b32", [(2**32 - 1, f(2.0**32)), (2**24 + 1, f(2.0**24)), (2**24 + 3, f(2.0**24 + 4))]),
    "cvt.rn.f32.s32": ("f32 b32", [(2**32 - 1, f(-1))]),
    "cvt.rn.f32.u64": ("f32 b64", [(2**64 - 1, f(2.0**64)), (2**40 + 2**16 + 1, f(2.0**40 + 2**17))]),
    "cvt.rn.f32.s16": ("f32 b16", [(0xFFFF, f(-1))]),
    "cvt.rn.f32.f64": ("f32 f64", [(d(1 + 2**-24), f(1)), (d(1e300), INFINITY), (d(2.0**-149), 1), (NAN_64, NAN)]),
    "cvt.f64.f32": ("f64 f32", [(1, d(2.0**-149))]),
    "cvt.f32.f16": ("f32 b16", [(0x3C00, f(1)), (1, f(2.0**-24)), (0x7C00, INFINITY), (0xFBFF, f(-65504)), (0x7E00, NAN), (0x8000, f(-0.0))]),
    "cvt.s64.s32": ("b64 b32", [(MIN_32, 2**64 - 2**31)]),
    "cvt.u64.u32": ("b64 b32", [(MIN_32, 2**31)]),
    "cvt.u32.u64": ("b32 b64", [(2**64 - 2, 2**32 - 2)]),
    "cvt.s16.s8": ("b16 b16", [(0x1280, 0xFF80), (0x127F, 0x7F)]),
    # A move between types keeps the bits of NaN.
    "mov.b32": ("b32 f32", [(OTHER_NAN, OTHER_NAN)]),
    "mov.f32": ("f32 f32", [(0x7F800001, 0x7F800001)]),
}
