// NVIDIA's driver, opened when a render asks for it: the few functions that Kindling calls.
//
// The library is no dependency of the program, so types, numbers and functions are declared here,
// by NVIDIA's "CUDA Driver API" reference.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace kindling::cuda {

using Status = int; // CUresult; 0: success
using DeviceNumber = int;
using Context = void*;
using Module = void*;
using Function = void*;
using Stream = void*;
using Event = void*;
using Link = void*;                 // CUlinkState
using Address = unsigned long long; // CUdeviceptr

// Values of CUdevice_attribute.
inline constexpr int kMajorCapability = 75, kMinorCapability = 76;
inline constexpr int kProcessors = 16, kThreadsPerProcessor = 39;
// Values of CUjit_option.
inline constexpr int kJitMaxRegisters = 0;
inline constexpr int kJitErrorLog = 5, kJitErrorLogBytes = 6;
// A value of CUjitInputType.
inline constexpr int kPtxInput = 1;

// KINDLING_CUDA_FUNCTIONS(FUNCTION): FUNCTION(member, "name in the library", parameters).
#define KINDLING_CUDA_FUNCTIONS(FUNCTION)                                                                              \
  FUNCTION(init, "cuInit", (unsigned flags))                                                                           \
  FUNCTION(driver_version, "cuDriverGetVersion", (int* version))                                                       \
  FUNCTION(device_count, "cuDeviceGetCount", (int* count))                                                             \
  FUNCTION(device, "cuDeviceGet", (DeviceNumber * device, int ordinal))                                                \
  FUNCTION(device_name, "cuDeviceGetName", (char* name, int bytes, DeviceNumber device))                               \
  FUNCTION(device_attribute, "cuDeviceGetAttribute", (int* value, int attribute, DeviceNumber device))                 \
  FUNCTION(retain_context, "cuDevicePrimaryCtxRetain", (Context * context, DeviceNumber device))                       \
  FUNCTION(release_context, "cuDevicePrimaryCtxRelease_v2", (DeviceNumber device))                                     \
  FUNCTION(use_context, "cuCtxSetCurrent", (Context context))                                                          \
  FUNCTION(memory, "cuMemGetInfo_v2", (size_t * free_bytes, size_t * total_bytes))                                     \
  FUNCTION(allocate, "cuMemAlloc_v2", (Address * address, size_t bytes))                                               \
  FUNCTION(release, "cuMemFree_v2", (Address address))                                                                 \
  FUNCTION(upload, "cuMemcpyHtoD_v2", (Address to, const void* from, size_t bytes))                                    \
  FUNCTION(download, "cuMemcpyDtoH_v2", (void* to, Address from, size_t bytes))                                        \
  FUNCTION(fill, "cuMemsetD8_v2", (Address to, unsigned char value, size_t bytes))                                     \
  FUNCTION(allocate_host, "cuMemAllocHost_v2", (void** memory, size_t bytes))                                          \
  FUNCTION(release_host, "cuMemFreeHost", (void* memory))                                                              \
  FUNCTION(upload_later, "cuMemcpyHtoDAsync_v2", (Address to, const void* from, size_t bytes, Stream stream))          \
  FUNCTION(wait, "cuCtxSynchronize", ())                                                                               \
  FUNCTION(lock_memory, "cuMemHostRegister_v2", (void* memory, size_t bytes, unsigned flags))                          \
  FUNCTION(unlock_memory, "cuMemHostUnregister", (void* memory))                                                       \
  FUNCTION(begin_link, "cuLinkCreate_v2", (unsigned option_count, int* options, void** values, Link* link))            \
  FUNCTION(add_to_link, "cuLinkAddData_v2",                                                                            \
           (Link link, int type, void* data, size_t bytes, const char* name, unsigned option_count, int* options,      \
            void** values))                                                                                            \
  FUNCTION(finish_link, "cuLinkComplete", (Link link, void** code, size_t* bytes))                                     \
  FUNCTION(end_link, "cuLinkDestroy", (Link link))                                                                     \
  FUNCTION(load_module, "cuModuleLoadData", (Module * module, const void* image))                                      \
  FUNCTION(unload_module, "cuModuleUnload", (Module module))                                                           \
  FUNCTION(function, "cuModuleGetFunction", (Function * function, Module module, const char* name))                    \
  FUNCTION(launch, "cuLaunchKernel",                                                                                   \
           (Function function, unsigned grid_x, unsigned grid_y, unsigned grid_z, unsigned block_x, unsigned block_y,  \
            unsigned block_z, unsigned shared_bytes, Stream stream, void** parameters, void** extra))                  \
  FUNCTION(create_event, "cuEventCreate", (Event * event, unsigned flags))                                             \
  FUNCTION(record_event, "cuEventRecord", (Event event, Stream stream))                                                \
  FUNCTION(event_milliseconds, "cuEventElapsedTime", (float* milliseconds, Event begin, Event end))                    \
  FUNCTION(destroy_event, "cuEventDestroy_v2", (Event event))                                                          \
  FUNCTION(error_name, "cuGetErrorName", (Status status, const char** name))                                           \
  FUNCTION(error_text, "cuGetErrorString", (Status status, const char** text))

// All functions are set.
struct Driver {
// NOLINTNEXTLINE(bugprone-macro-parentheses): a declarator has none there
#define KINDLING_CUDA_MEMBER(member, name, parameters) Status(*member) parameters = nullptr;
  KINDLING_CUDA_FUNCTIONS(KINDLING_CUDA_MEMBER)
#undef KINDLING_CUDA_MEMBER
  std::shared_ptr<void> library;

  // Returns words for a failure: "out of memory (CUDA_ERROR_OUT_OF_MEMORY)".
  [[nodiscard]] std::string words_for(Status status) const;
};

// Opens libcuda.so.1, or the library that KINDLING_CUDA_DRIVER names, and initializes it. Fails
// (render_failed) if there is none, if it lacks a function, or if it is too old.
[[nodiscard]] Result<Driver> open_driver();

} // namespace kindling::cuda
