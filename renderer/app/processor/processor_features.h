// Processor features as bits, for the check before any other code of the program runs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling::app {

// Feature names are GCC's; the order is that of kProcessorFeatureNames in processor_check.cpp.
enum ProcessorFeature : uint32_t {
  kSse3 = 1U << 0,
  kSsse3 = 1U << 1,
  kSse41 = 1U << 2,
  kSse42 = 1U << 3,
  kPopcnt = 1U << 4,
  kAvx = 1U << 5,
  kAvx2 = 1U << 6,
  kFma = 1U << 7,
  kBmi = 1U << 8,
  kBmi2 = 1U << 9,
  kAvx512f = 1U << 10,
  kAvx512dq = 1U << 11,
  kAvx512bw = 1U << 12,
  kAvx512vl = 1U << 13,
};

// The features that KINDLING_ARCH allowed the compiler to use in all sources. Constant data:
// reading it runs no code that was compiled for them.
extern const uint32_t kCompiledForFeatures;
// KINDLING_ARCH: the value of -march=, "x86-64-v3" for example.
extern const char* const kCompiledForArchitecture;

} // namespace kindling::app
