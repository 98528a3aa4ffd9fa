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

// 2^r, |r| <= 1/128, but for its first coefficient, 1; error 6.6e-09.
inline constexpr double kExp2Near[] = {0x1.62e48530c6c48p-1, 0x1.ebfc42758d720p-3};
// log2(1 + r) / r, |r| <= 1/256; error 5.4e-09.
inline constexpr double kLog2Near[] = {0x1.71547652a5b86p+0, -0x1.715500d2bb034p-1, 0x1.ec720f19306a1p-2};
// the same for pow(); error 8.4e-12.
inline constexpr double kLog2Nearer[] = {0x1.71547652aef42p+0, -0x1.715476527aa18p-1, 0x1.ec71c53b3c3a9p-2,
                                         -0x1.7155e7a87684ep-2};
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

// The bits of 2^(i / 64) less i 2^52 / 64. Adding k 2^52 / 64 gives those of
// 2^(k / 64) for i = k mod 64.
inline constexpr uint64_t kExp2Table[] = {
    0x3ff0000000000000, 0x3fefec9a3e778061, 0x3fefd9b0d3158574, 0x3fefc74518759bc8, 0x3fefb5586cf9890f,
    0x3fefa3ec32d3d1a2, 0x3fef9301d0125b51, 0x3fef829aaea92de0, 0x3fef72b83c7d517b, 0x3fef635beb6fcb75,
    0x3fef54873168b9aa, 0x3fef463b88628cd6, 0x3fef387a6e756238, 0x3fef2b4565e27cdd, 0x3fef1e9df51fdee1,
    0x3fef1285a6e4030b, 0x3fef06fe0a31b715, 0x3feefc08b26416ff, 0x3feef1a7373aa9cb, 0x3feee7db34e59ff7,
    0x3feedea64c123422, 0x3feed60a21f72e2a, 0x3feece086061892d, 0x3feec6a2b5c13cd0, 0x3feebfdad5362a27,
    0x3feeb9b2769d2ca7, 0x3feeb42b569d4f82, 0x3feeaf4736b527da, 0x3feeab07dd485429, 0x3feea76f15ad2148,
    0x3feea47eb03a5585, 0x3feea23882552225, 0x3feea09e667f3bcd, 0x3fee9fb23c651a2f, 0x3fee9f75e8ec5f74,
    0x3fee9feb564267c9, 0x3feea11473eb0187, 0x3feea2f336cf4e62, 0x3feea589994cce13, 0x3feea8d99b4492ed,
    0x3feeace5422aa0db, 0x3feeb1ae99157736, 0x3feeb737b0cdc5e5, 0x3feebd829fde4e50, 0x3feec49182a3f090,
    0x3feecc667b5de565, 0x3feed503b23e255d, 0x3feede6b5579fdbf, 0x3feee89f995ad3ad, 0x3feef3a2b84f15fb,
    0x3feeff76f2fb5e47, 0x3fef0c1e904bc1d2, 0x3fef199bdd85529c, 0x3fef27f12e57d14b, 0x3fef3720dcef9069,
    0x3fef472d4a07897c, 0x3fef5818dcfba487, 0x3fef69e603db3285, 0x3fef7c97337b9b5f, 0x3fef902ee78b3ff6,
    0x3fefa4afa2a490da, 0x3fefba1bee615a27, 0x3fefd0765b6e4540, 0x3fefe7c1819e90d8};

// Mantissas from that of these bits of a float to twice that are divided into 128 intervals.
inline constexpr uint32_t kMinMantissa = 0x3f7f5556;
// The inverse of the middle of each interval, and the logarithm of the middle.
struct Log2Entry {
  double inverse;
  double log2;
};
inline constexpr Log2Entry kLog2Table[] = {{0x1.0000000000000p+0, 0x0.0p+0},
                                           {0x1.fcb02d0ea757bp-1, 0x1.32c7f82b0acb0p-7},
                                           {0x1.f8c52a6e1036ap-1, 0x1.502714fe6aee4p-6},
                                           {0x1.f4e97cf55a597p-1, 0x1.02c19906b1e2ep-5},
                                           {0x1.f11ccb5262018p-1, 0x1.5cbee5628e83fp-5},
                                           {0x1.ed5ebee39466fp-1, 0x1.b60e1b7701a83p-5},
                                           {0x1.e9af039e362dcp-1, 0x1.0758ebe27bceep-4},
                                           {0x1.e60d47f5cee99p-1, 0x1.335653efaff06p-4},
                                           {0x1.e2793cc4aa93fp-1, 0x1.5f00856e126f5p-4},
                                           {0x1.def2953562bdfp-1, 0x1.8a58b8e07f883p-4},
                                           {0x1.db7906ad62189p-1, 0x1.b5601ff628dbbp-4},
                                           {0x1.d80c48b855b38p-1, 0x1.e017e5bd1eae4p-4},
                                           {0x1.d4ac14f4800d8p-1, 0x1.05409769846c6p-3},
                                           {0x1.d15826ffe2bb4p-1, 0x1.1a4e8cca11ac9p-3},
                                           {0x1.ce103c66340f3p-1, 0x1.2f365f2448a69p-3},
                                           {0x1.cad4148f96c18p-1, 0x1.43f897a80c2bbp-3},
                                           {0x1.c7a370b00a282p-1, 0x1.5895bca62aba6p-3},
                                           {0x1.c47e13b78a12ap-1, 0x1.6d0e51a4bdc2bp-3},
                                           {0x1.c163c242d5dc0p-1, 0x1.8162d772d57c6p-3},
                                           {0x1.be54428cd6b9fp-1, 0x1.9593cc3b78a90p-3},
                                           {0x1.bb4f5c609dbe5p-1, 0x1.a9a1ab97ff4a0p-3},
                                           {0x1.b854d90bf26a0p-1, 0x1.bd8ceea1ceee1p-3},
                                           {0x1.b56483526b0e2p-1, 0x1.d1560c037efe5p-3},
                                           {0x1.b27e276108985p-1, 0x1.e4fd78096b128p-3},
                                           {0x1.afa192c24fb97p-1, 0x1.f883a4b1b91d0p-3},
                                           {0x1.acce9452d9aa3p-1, 0x1.05f480ddec779p-2},
                                           {0x1.aa04fc36571b4p-1, 0x1.0f96fe5bc12e8p-2},
                                           {0x1.a7449bcd0027ep-1, 0x1.192980899b85bp-2},
                                           {0x1.a48d45a96c664p-1, 0x1.22ac3c152654fp-2},
                                           {0x1.a1decd86ce6dep-1, 0x1.2c1f64a94221dp-2},
                                           {0x1.9f39083f8e6d8p-1, 0x1.35832cf49978cp-2},
                                           {0x1.9c9bcbc43f9d6p-1, 0x1.3ed7c6b0001a3p-2},
                                           {0x1.9a06ef12ec957p-1, 0x1.481d62a49ef35p-2},
                                           {0x1.977a4a2eb6bd4p-1, 0x1.515430b1eed4dp-2},
                                           {0x1.94f5b617c53f7p-1, 0x1.5a7c5fd383b60p-2},
                                           {0x1.92790cc380143p-1, 0x1.63961e26aa48cp-2},
                                           {0x1.9004291513e2cp-1, 0x1.6ca198efd98dap-2},
                                           {0x1.8d96e6d63ba30p-1, 0x1.759efc9ff9fd2p-2},
                                           {0x1.8b3122b04d0bep-1, 0x1.7e8e74d983d83p-2},
                                           {0x1.88d2ba258502bp-1, 0x1.87702c757611bp-2},
                                           {0x1.867b8b8a915e4p-1, 0x1.90444d8827418p-2},
                                           {0x1.842b760055750p-1, 0x1.990b0165f1f3dp-2},
                                           {0x1.81e2596de7076p-1, 0x1.a1c470a7bdaa0p-2},
                                           {0x1.7fa0167ac1393p-1, 0x1.aa70c32f65c37p-2},
                                           {0x1.7d648e892b658p-1, 0x1.b310202bff83cp-2},
                                           {0x1.7b2fa3b0d1b2dp-1, 0x1.bba2ae1e005ccp-2},
                                           {0x1.790138b98d67ap-1, 0x1.c42892db45924p-2},
                                           {0x1.76d931165b15ap-1, 0x1.cca1f392fe46fp-2},
                                           {0x1.74b770e07cc81p-1, 0x1.d50ef4d178f69p-2},
                                           {0x1.729bdcd2c6776p-1, 0x1.dd6fba83d555ap-2},
                                           {0x1.70865a4513187p-1, 0x1.e5c467fb9b852p-2},
                                           {0x1.6e76cf27e0b06p-1, 0x1.ee0d1ff239807p-2},
                                           {0x1.6c6d220011e7dp-1, 0x1.f64a048c67a28p-2},
                                           {0x1.6a6939e2d3aa4p-1, 0x1.fe7b375d75171p-2},
                                           {0x1.686afe71a56e9p-1, 0x1.03506cb53e808p-1},
                                           {0x1.667257d682d48p-1, 0x1.075d8596c28ecp-1},
                                           {0x1.647f2ec02d523p-1, 0x1.0b64f64c434f7p-1},
                                           {0x1.62916c5e94bb2p-1, 0x1.0f66ce8c30faep-1},
                                           {0x1.60a8fa5f5d774p-1, 0x1.13631dcbdf1a0p-1},
                                           {0x1.5ec5c2ea834d1p-1, 0x1.1759f340ea5aep-1},
                                           {0x1.5ce7b09f17adbp-1, 0x1.1b4b5de294d8cp-1},
                                           {0x1.5b0eae901a7f6p-1, 0x1.1f376c6b19235p-1},
                                           {0x1.593aa8416c6acp-1, 0x1.231e2d58f4535p-1},
                                           {0x1.576b89a4d9bbep-1, 0x1.26ffaef02772ep-1},
                                           {0x1.55a13f173cf1fp-1, 0x1.2adbff3b707f8p-1},
                                           {0x1.53dbb55db8207p-1, 0x1.2eb32c0d7b497p-1},
                                           {0x1.521ad9a304507p-1, 0x1.328543020a6fap-1},
                                           {0x1.505e9974d615fp-1, 0x1.3652517f18b81p-1},
                                           {0x1.4ea6e2c156985p-1, 0x1.3a1a64b5f3009p-1},
                                           {0x1.4cf3a3d4b0536p-1, 0x1.3ddd89a44b00dp-1},
                                           {0x1.4b44cb56aedebp-1, 0x1.419bcd1543158p-1},
                                           {0x1.499a4848710f0p-1, 0x1.45553ba2734ccp-1},
                                           {0x1.47f40a022ccddp-1, 0x1.4909e1b4e7e55p-1},
                                           {0x1.4652003104093p-1, 0x1.4cb9cb8619730p-1},
                                           {0x1.44b41ad4ea234p-1, 0x1.50650520dedb2p-1},
                                           {0x1.431a4a3e99506p-1, 0x1.540b9a625954dp-1},
                                           {0x1.41847f0d9757bp-1, 0x1.57ad96fada9bfp-1},
                                           {0x1.3ff2aa2e492f2p-1, 0x1.5b4b066ec5825p-1},
                                           {0x1.3e64bcd814f24p-1, 0x1.5ee3f41769086p-1},
                                           {0x1.3cdaa88b91b68p-1, 0x1.62786b23d627dp-1},
                                           {0x1.3b545f10c4c6bp-1, 0x1.66087699b0748p-1},
                                           {0x1.39d1d2756bd11p-1, 0x1.69942155f9bdcp-1},
                                           {0x1.3852f50b539b2p-1, 0x1.6d1b760dd8d09p-1},
                                           {0x1.36d7b966bacf5p-1, 0x1.709e7f4f5b816p-1},
                                           {0x1.3560125cc07f0p-1, 0x1.741d4782341e0p-1},
                                           {0x1.33ebf301ddf60p-1, 0x1.7797d8e8726a1p-1},
                                           {0x1.327b4ea86b809p-1, 0x1.7b0e3d9f38455p-1},
                                           {0x1.310e18df2fc95p-1, 0x1.7e807f9f6a1a6p-1},
                                           {0x1.2fa4456ff975bp-1, 0x1.81eea8be5b362p-1},
                                           {0x1.2e3dc85e42ae1p-1, 0x1.8558c2ae7621ep-1},
                                           {0x1.2cda95e5de3e6p-1, 0x1.88bed6ffe11f3p-1},
                                           {0x1.2b7aa279ae019p-1, 0x1.8c20ef211edeap-1},
                                           {0x1.2a1de2c2624bep-1, 0x1.8f7f145fab8cep-1},
                                           {0x1.28c44b9d420acp-1, 0x1.92d94fe8964fcp-1},
                                           {0x1.276dd21afb546p-1, 0x1.962faac9174b1p-1},
                                           {0x1.261a6b7e7c22ep-1, 0x1.99822def2245dp-1},
                                           {0x1.24ca0d3bd2f99p-1, 0x1.9cd0e229f6079p-1},
                                           {0x1.237cacf717356p-1, 0x1.a01bd02aa882ep-1},
                                           {0x1.2232408358cbbp-1, 0x1.a3630084afe44p-1},
                                           {0x1.20eabde1973c7p-1, 0x1.a6a67bae6899ep-1},
                                           {0x1.1fa61b3fbf7fcp-1, 0x1.a9e64a0198677p-1},
                                           {0x1.1e644ef7b0b6cp-1, 0x1.ad2273bbee9e3p-1},
                                           {0x1.1d254f8e476d5p-1, 0x1.b05b00ff81854p-1},
                                           {0x1.1be913b26f372p-1, 0x1.b38ff9d3490c9p-1},
                                           {0x1.1aaf923c3a78fp-1, 0x1.b6c1662396d6cp-1},
                                           {0x1.1978c22c002d5p-1, 0x1.b9ef4dc28baeep-1},
                                           {0x1.18449aa97f77cp-1, 0x1.bd19b8688a78ep-1},
                                           {0x1.1713130308d95p-1, 0x1.c040adb4a8aeep-1},
                                           {0x1.15e422acacdc4p-1, 0x1.c364352d1c7abp-1},
                                           {0x1.14b7c13f700d8p-1, 0x1.c684563fa87a2p-1},
                                           {0x1.138de678841bap-1, 0x1.c9a11842053eep-1},
                                           {0x1.12668a3885f4cp-1, 0x1.ccba82724897ep-1},
                                           {0x1.1141a482c0be6p-1, 0x1.cfd09bf74ab1cp-1},
                                           {0x1.101f2d7c75829p-1, 0x1.d2e36be1091d3p-1},
                                           {0x1.0eff1d6c27707p-1, 0x1.d5f2f92907c6ep-1},
                                           {0x1.0de16cb8ec8ccp-1, 0x1.d8ff4ab2aff1ap-1},
                                           {0x1.0cc613e9c2b39p-1, 0x1.dc08674bad3a2p-1},
                                           {0x1.0bad0ba4e8ca6p-1, 0x1.df0e55ac48b57p-1},
                                           {0x1.0a964caf3c046p-1, 0x1.e2111c77c2332p-1},
                                           {0x1.0981cfeb991b9p-1, 0x1.e510c23ca7afep-1},
                                           {0x1.086f8e5a4161bp-1, 0x1.e80d4d752b03dp-1},
                                           {0x1.075f8118438e1p-1, 0x1.eb06c48775d5dp-1},
                                           {0x1.0651a15ee82c2p-1, 0x1.edfd2dc5fbe24p-1},
                                           {0x1.0545e88321927p-1, 0x1.f0f08f6fcb9abp-1},
                                           {0x1.043c4ff4ff47bp-1, 0x1.f3e0efb0dd2c8p-1},
                                           {0x1.0334d13f24be3p-1, 0x1.f6ce54a25ff5ep-1},
                                           {0x1.022f6606434ddp-1, 0x1.f9b8c44b06738p-1},
                                           {0x1.012c08089755ep-1, 0x1.fca0449f50b0ap-1}};

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
