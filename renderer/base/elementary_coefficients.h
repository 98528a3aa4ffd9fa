// Coefficients of the elementary functions, written by fit_elementary.py.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling::elementary {

inline constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1; // 2 / pi
inline constexpr double kHalfPiUpper =
    0x1.921fb54400000p+0; // 33 bits of pi / 2, whose products with integers below 2^20 are exact
inline constexpr double kHalfPiLower = 0x1.0b4611a626331p-34;   // the rest of it
inline constexpr double kHalfPi = 0x1.921fb54442d18p+0;         // pi / 2, nearest
inline constexpr double kHalfPiRest = 0x1.1a62633145c07p-54;    // the rest of it
inline constexpr double kQuarterPi = 0x1.921fb54442d18p-1;      // pi / 4, nearest
inline constexpr double kQuarterPiRest = 0x1.1a62633145c07p-55; // the rest of it
inline constexpr double kTanEighthPi = 0x1.a827999fcef32p-2;    // tan(pi / 8)
inline constexpr double kLog2E = 0x1.71547652b82fep+0;          // log2(e), nearest
inline constexpr double kLog2ERest = 0x1.777d0ffda0d24p-56;     // the rest of it
inline constexpr double kLn2 = 0x1.62e42fefa39efp-1;            // log(2), nearest
inline constexpr double kLn2Upper = 0x1.62e42fefa3800p-1;  // 42 bits of log(2), whose products with exponents are exact
inline constexpr double kLn2Lower = 0x1.ef35793c76730p-45; // the rest of it
inline constexpr double kThird = 0x1.5555555555555p-2;     // 1 / 3, nearest
inline constexpr double kThirdRest = 0x1.5555555555555p-56; // the rest of it

// (2^r - 1) / r, |r| <= 1/2; error 7.5e-09.
inline constexpr double kExp2Short[] = {0x1.62e4302fd3ddbp-1, 0x1.ebfbe07d8f74fp-3,  0x1.c6af6cc049acdp-5,
                                        0x1.3b29e3d4caebep-7, 0x1.5f089dd2fde88p-10, 0x1.446c7dc56f3f8p-13};
// (log(m) / s - 2) / s^2, in s^2, s = (m - 1) / (m + 1), m up to sqrt(2); error times s^2 1.6e-09.
inline constexpr double kLogShort[] = {0x1.55557a2562524p-1, 0x1.995eba30dfd01p-2, 0x1.31e2eec5933b8p-2};
// (log2(m) / s - 2 log2(e)) / s^2, in s^2; error times s^2 2.3e-09.
inline constexpr double kLog2Short[] = {0x1.ec70d2dfa8407p-1, 0x1.274c4d55bdab9p-1, 0x1.b94d060292e0fp-2};
// as kLog2Short, in s^2, for pow(); error times s^2 1.4e-11.
inline constexpr double kLog2Medium[] = {0x1.ec709d4518a75p-1, 0x1.2777674cf5b7cp-1, 0x1.a5965a85ec143p-2,
                                         0x1.5c621ed59308dp-2};
// (sin(r) / r - 1) / r^2, in r^2, |r| <= pi/4; error times r^2 3.6e-09.
inline constexpr double kSinShort[] = {-0x1.555545985af6fp-3, 0x1.11075fd1a3b87p-7, -0x1.994e83d7a1371p-13};
// (cos(r) - 1) / r^2, in r^2, |r| <= pi/4; error times r^2 5.4e-11.
inline constexpr double kCosShort[] = {-0x1.ffffffd0c269dp-2, 0x1.55553e0ed993cp-5, -0x1.6c087ddc872a6p-10,
                                       0x1.993404f6ed2a7p-16};
// (asin(s) / s - 1) / s^2, in s^2, |s| <= 1/2; error times s^2 2.8e-10.
inline constexpr double kAsinShort[] = {0x1.55554c3701d90p-3, 0x1.33388e89d8b95p-4, 0x1.6cac406d4d506p-5,
                                        0x1.04a6387651729p-5, 0x1.d7f3c3dadd380p-7, 0x1.33bb573e09e98p-5};
// (atan(t) / t - 1) / t^2, in t^2, |t| <= tan(pi/8); error times t^2 2.2e-11.
inline constexpr double kAtanShort[] = {-0x1.555554c8a01e8p-2, 0x1.99991a4b2a164p-3,  -0x1.247f06bd13fe5p-3,
                                        0x1.c46806bb01f99p-4,  -0x1.5b457e30a2607p-4, 0x1.84f5fe0cce172p-5};
// (2^r - 1 - r log(2)) / r^2, |r| <= 1/2; error 1.1e-17.
inline constexpr double kExp2Long[] = {0x1.ebfbdff82c58fp-3,  0x1.c6b08d704a0c2p-5,  0x1.3b2ab6fba4e79p-7,
                                       0x1.5d87fe78a5275p-10, 0x1.430912f86b063p-13, 0x1.ffcbfc670e2dcp-17,
                                       0x1.62c0224555877p-20, 0x1.b524fae525af4p-24, 0x1.e4cf04ec2cbdap-28,
                                       0x1.e9d4000475d68p-32, 0x1.c4b5b0ee59b4bp-36};
// (e^r - 1 - r) / r^2, |r| <= log(2) / 2; error 2.5e-18.
inline constexpr double kExpLong[] = {0x1.0000000000000p-1,  0x1.5555555555557p-3,  0x1.5555555555558p-5,
                                      0x1.11111111100dep-7,  0x1.6c16c16c15202p-10, 0x1.a01a01abe67c4p-13,
                                      0x1.a01a01acf8d29p-16, 0x1.71de02367c30ep-19, 0x1.27e4ccd2b07bap-22,
                                      0x1.af4ddf18d0754p-26, 0x1.1f8b445a11160p-29};
// (atanh(s) / s - 1) / s^2, in s^2; error times s^2 5.4e-19.
inline constexpr double kLogLong[] = {
    0x1.5555555555555p-2, 0x1.999999999999ap-3, 0x1.2492492492450p-3, 0x1.c71c71c7258f6p-4, 0x1.745d1740100d8p-4,
    0x1.3b13b37a3e094p-4, 0x1.111081b8ddd1ep-4, 0x1.e20f86df2f762p-5, 0x1.aaadcf8c8bd39p-5, 0x1.c4b4c4970faefp-5};
// (atanh(s) / s - 1 - s^2 / 3) / s^4, in s^2; error times s^2 3.2e-19.
inline constexpr double kLogRest[] = {0x1.999999999999ap-3, 0x1.2492492492492p-3, 0x1.c71c71c71c71ep-4,
                                      0x1.745d1745d1558p-4, 0x1.3b13b13b2b55cp-4, 0x1.11111105a801bp-4,
                                      0x1.e1e1e9197abbbp-5, 0x1.af26e7884adb3p-5, 0x1.864e0709d2c25p-5,
                                      0x1.5f81b3855c56ap-5, 0x1.827070ffd0303p-5};
// as kSinShort, in r^2; error times r^2 5.5e-18.
inline constexpr double kSinLong[] = {-0x1.5555555555555p-3, 0x1.111111111110bp-7,   -0x1.a01a01a018ae7p-13,
                                      0x1.71de3a5339b2ap-19, -0x1.ae6452989b368p-26, 0x1.612092eb86332p-33,
                                      -0x1.aaa561779d1efp-41};
// (cos(r) - 1 + r^2 / 2) / r^4, in r^2; error times r^2 1.4e-18.
inline constexpr double kCosLong[] = {0x1.5555555555555p-5,   -0x1.6c16c16c16c14p-10, 0x1.a01a01a0196acp-16,
                                      -0x1.27e4fb768fac5p-22, 0x1.1eed8d4362fa0p-29,  -0x1.9393e7fedb444p-37,
                                      0x1.ab128b3e44b1dp-45};
// as kAsinShort, in s^2; error times s^2 2.9e-18.
inline constexpr double kAsinLong[] = {
    0x1.5555555555552p-3,  0x1.3333333333c69p-4, 0x1.6db6db6d30f70p-5,  0x1.f1c71cb0e5841p-6, 0x1.6e8b99f92221cp-6,
    0x1.1c4f97db9c3fap-6,  0x1.c97f01862456fp-7, 0x1.7bb568270cb96p-7,  0x1.3652abd0d1be3p-7, 0x1.4a0fa86fb3b07p-7,
    0x1.f8fe4e7c602bbp-12, 0x1.9da43e506084fp-6, -0x1.b4f6f9547af8ep-6, 0x1.15fa4340c38f2p-5};
// as kAtanShort, in t^2; error times t^2 8.7e-19.
inline constexpr double kAtanLong[] = {-0x1.5555555555554p-2, 0x1.99999999995f8p-3,  -0x1.2492492473980p-3,
                                       0x1.c71c71b69a51ep-4,  -0x1.745d14a5c4b38p-4, 0x1.3b136cb76e34fp-4,
                                       -0x1.110c607bc874cp-4, 0x1.e170ca299a5f7p-5,  -0x1.ab76ade06f988p-5,
                                       0x1.70d4b838fd68ep-5,  -0x1.1204a76b073b8p-5, 0x1.f12dd93e06946p-7};

// 64 zeros and the first 1280 bits of 2 / pi.
inline constexpr uint64_t kTwoOverPiBits[] = {0,
                                              0xa2f9836e4e441529,
                                              0xfc2757d1f534ddc0,
                                              0xdb6295993c439041,
                                              0xfe5163abdebbc561,
                                              0xb7246e3a424dd2e0,
                                              0x06492eea09d1921c,
                                              0xfe1deb1cb129a73e,
                                              0xe88235f52ebb4484,
                                              0xe99c7026b45f7e41,
                                              0x3991d639835339f4,
                                              0x9c845f8bbdf9283b,
                                              0x1ff897ffde05980f,
                                              0xef2f118b5a0a6d1f,
                                              0x6d367ecf27cb09b7,
                                              0x4f463f669e5fea2d,
                                              0x7527bac7ebe5f17b,
                                              0x3d0739f78a5292ea,
                                              0x6bfb5fb11f8d5d08,
                                              0x56033046fc7b6bab,
                                              0xf0cfbc209af4361d};

} // namespace kindling::elementary
