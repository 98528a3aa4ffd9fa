// Entry points of the kernels for GPUs, one thread for each number. clang compiles this to PTX,
// together with the sources of what the kernels call (gpu_sources.txt).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/kernels/all_kernels.h"
#include "renderer/world/probes.h"

#include <cstdint>

namespace kindling {

// A device has no accelerator but the tree.
accel::Hit WorldView::probe_hit(const accel::Ray& ray) const { return compact_probe_hit(*this, ray); }
bool WorldView::probe_is_blocked(const accel::Ray& ray) const { return compact_probe_is_blocked(*this, ray); }
bool WorldView::sight_is_blocked(const accel::Ray& ray) const { return compact_sight_is_blocked(*this, ray); }
// Scenes on a device have all texels in memory.
void TextureView::fetch(int /*level*/, const std::array<int, 2>& /*x*/, const std::array<int, 2>& /*y*/,
                        std::byte* /*texels*/) const {
  __builtin_trap();
}

// The cache is the processor's: its threads fill it while they render.
WhittedTerms WhittedShader::cached_terms(const accel::Hit& /*hit*/, const SurfacePoint& /*surface*/,
                                         WhittedCounters& /*counters*/) const {
  __builtin_trap();
}

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
