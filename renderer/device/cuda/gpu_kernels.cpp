// The PTX of the kernels as bytes of the program.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/cuda/gpu_kernels.h"

#ifdef KINDLING_GPU_KERNELS
#if __has_include(KINDLING_GPU_KERNELS_HASH) // not in a folder where nothing was built yet
#include KINDLING_GPU_KERNELS_HASH
#endif
asm(R"(
  .section .rodata
  .global kindling_gpu_kernels_begin
  .global kindling_gpu_kernels_end
kindling_gpu_kernels_begin:
  .incbin ")" KINDLING_GPU_KERNELS R"("
kindling_gpu_kernels_end:
  .byte 0
  .previous
)");
extern "C" const char kindling_gpu_kernels_begin[], kindling_gpu_kernels_end[];
#endif

namespace kindling {

std::string_view gpu_kernels() {
#ifdef KINDLING_GPU_KERNELS
  return {kindling_gpu_kernels_begin, static_cast<size_t>(kindling_gpu_kernels_end - kindling_gpu_kernels_begin)};
#else
  return {};
#endif
}

} // namespace kindling
