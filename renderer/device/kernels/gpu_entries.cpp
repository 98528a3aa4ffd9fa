// Entry points of the kernels for GPUs, one thread for each number. clang compiles this to PTX,
// together with the sources of what the kernels call (gpu_sources.txt).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/kernels/all_kernels.h"

#include <cstdint>

namespace kindling {

namespace {

#if defined(__NVPTX__)
#define KINDLING_GPU_KERNEL [[clang::nvptx_kernel]]
uint32_t thread_number() {
  return __nvvm_read_ptx_sreg_ctaid_x() * __nvvm_read_ptx_sreg_ntid_x() + __nvvm_read_ptx_sreg_tid_x();
}
#elif defined(__AMDGCN__)
#define KINDLING_GPU_KERNEL [[clang::amdgpu_kernel]]
uint32_t thread_number() {
  return __builtin_amdgcn_workgroup_id_x() * __builtin_amdgcn_workgroup_size_x() + __builtin_amdgcn_workitem_id_x();
}
#endif

} // namespace
} // namespace kindling

#define KINDLING_ENTRY(name, argument)                                                                                 \
  extern "C" KINDLING_GPU_KERNEL void kindling_##name(const kindling::argument* wave, uint32_t count) {                \
    const uint32_t number = kindling::thread_number();                                                                 \
    if (number < count) kindling::kernels::name(*wave, number);                                                        \
  }
KINDLING_KERNELS(KINDLING_ENTRY)
#undef KINDLING_ENTRY
