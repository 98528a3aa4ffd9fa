// The processor features that this build uses, as constant data.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/processor/processor_features.h"

namespace kindling::app {

namespace {

constexpr uint32_t features() {
  uint32_t mask = 0;
#ifdef __SSE3__
  mask |= kSse3;
#endif
#ifdef __SSSE3__
  mask |= kSsse3;
#endif
#ifdef __SSE4_1__
  mask |= kSse41;
#endif
#ifdef __SSE4_2__
  mask |= kSse42;
#endif
#ifdef __POPCNT__
  mask |= kPopcnt;
#endif
#ifdef __AVX__
  mask |= kAvx;
#endif
#ifdef __AVX2__
  mask |= kAvx2;
#endif
#ifdef __FMA__
  mask |= kFma;
#endif
#ifdef __BMI__
  mask |= kBmi;
#endif
#ifdef __BMI2__
  mask |= kBmi2;
#endif
#ifdef __AVX512F__
  mask |= kAvx512f;
#endif
#ifdef __AVX512DQ__
  mask |= kAvx512dq;
#endif
#ifdef __AVX512BW__
  mask |= kAvx512bw;
#endif
#ifdef __AVX512VL__
  mask |= kAvx512vl;
#endif
  return mask;
}

} // namespace

constinit const uint32_t kCompiledForFeatures = features();
constinit const char* const kCompiledForArchitecture = KINDLING_TARGET_ARCH;

} // namespace kindling::app
