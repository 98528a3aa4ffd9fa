// Entry points of the kernels for GPUs, one thread for each number. clang compiles this to PTX,
// together with the sources of what the kernels call (gpu_sources.txt).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/gpu_thread.h"
#include "renderer/device/kernels/all_kernels.h"

#include <cstdint>

#if defined(__NVPTX__)
#define KINDLING_GPU_KERNEL [[clang::nvptx_kernel]]
#elif defined(__AMDGCN__)
#define KINDLING_GPU_KERNEL [[clang::amdgpu_kernel]]
#endif

#define KINDLING_ENTRY(name, argument)                                                                                 \
  extern "C" KINDLING_GPU_KERNEL void kindling_##name(const kindling::argument* wave, uint32_t count) {                \
    const uint32_t number = kindling::gpu_thread_number();                                                             \
    if (number < count) [[clang::always_inline]]                                                                       \
      kindling::kernels::name(*wave, number);                                                                          \
  }
KINDLING_KERNELS(KINDLING_ENTRY)
#undef KINDLING_ENTRY
