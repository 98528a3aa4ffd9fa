// The number of a GPU's thread within its launch.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/on_gpu.h"

#include <cstdint>

#if KINDLING_ON_GPU
namespace kindling {

inline uint32_t gpu_thread_number() {
#if defined(__NVPTX__)
  return __nvvm_read_ptx_sreg_ctaid_x() * __nvvm_read_ptx_sreg_ntid_x() + __nvvm_read_ptx_sreg_tid_x();
#else
  return __builtin_amdgcn_workgroup_id_x() * __builtin_amdgcn_workgroup_size_x() + __builtin_amdgcn_workitem_id_x();
#endif
}

} // namespace kindling
#endif
