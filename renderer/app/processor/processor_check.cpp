// Ends the program with one line on a processor without the features that it was compiled for.
// It runs before all initializers and is compiled for the oldest processor of the architecture. It
// includes no inline functions, of which the linker might keep a copy compiled for a newer one.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/processor/processor_features.h"

#if defined(__x86_64__)

#include <cstring>

#include <unistd.h>

namespace kindling::app {

namespace {

constexpr int kExitCannotRun = 1; // kExitRenderFailed of exit_code.h

struct Message {
  char text[512];
  size_t length;
};

void append(Message& message, const char* text) {
  const size_t count = strnlen(text, sizeof message.text - message.length);
  memcpy(message.text + message.length, text, count);
  message.length += count;
}

// Appends ", NAME" if the program uses a feature that the processor lacks.
void list_if_missing(Message& message, ProcessorFeature feature, bool present, const char* name) {
  if ((kCompiledForFeatures & feature) == 0 || present) return;
  append(message, message.length == 0 ? "kindling: error: this processor lacks " : ", ");
  append(message, name);
}

// Priorities up to 100 are the compiler's; our own initializers have none and run later.
__attribute__((constructor(101))) void check_processor() {
  __builtin_cpu_init();
  Message message{};
  list_if_missing(message, kSse3, __builtin_cpu_supports("sse3"), "SSE3");
  list_if_missing(message, kSsse3, __builtin_cpu_supports("ssse3"), "SSSE3");
  list_if_missing(message, kSse41, __builtin_cpu_supports("sse4.1"), "SSE4.1");
  list_if_missing(message, kSse42, __builtin_cpu_supports("sse4.2"), "SSE4.2");
  list_if_missing(message, kPopcnt, __builtin_cpu_supports("popcnt"), "POPCNT");
  list_if_missing(message, kAvx, __builtin_cpu_supports("avx"), "AVX");
  list_if_missing(message, kAvx2, __builtin_cpu_supports("avx2"), "AVX2");
  list_if_missing(message, kFma, __builtin_cpu_supports("fma"), "FMA");
  list_if_missing(message, kBmi, __builtin_cpu_supports("bmi"), "BMI");
  list_if_missing(message, kBmi2, __builtin_cpu_supports("bmi2"), "BMI2");
  list_if_missing(message, kAvx512f, __builtin_cpu_supports("avx512f"), "AVX-512F");
  list_if_missing(message, kAvx512dq, __builtin_cpu_supports("avx512dq"), "AVX-512DQ");
  list_if_missing(message, kAvx512bw, __builtin_cpu_supports("avx512bw"), "AVX-512BW");
  list_if_missing(message, kAvx512vl, __builtin_cpu_supports("avx512vl"), "AVX-512VL");
  if (message.length == 0) return;
  append(message, "; the program was compiled for ");
  append(message, kCompiledForArchitecture);
  append(message, ": build Kindling with -DKINDLING_ARCH=x86-64 for this machine\n");
  if (write(STDERR_FILENO, message.text, message.length) < 0) _exit(kExitCannotRun);
  _exit(kExitCannotRun);
}

} // namespace

} // namespace kindling::app

#endif
