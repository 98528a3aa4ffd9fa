// Open Image Denoise, opened when an image is denoised: the few functions that Kindling calls.
//
// The library is no dependency of the program, so types, numbers and functions are declared here,
// by the API reference of Open Image Denoise 2.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

namespace kindling::oidn {

using Device = void*;
using Filter = void*;
using Progress = bool (*)(void* user, double fraction); // false: cancel

inline constexpr int kCpuDevice = 1;                     // OIDNDeviceType
inline constexpr int kFloat3 = 3;                        // OIDNFormat
inline constexpr int kFastQuality = 4, kHighQuality = 6; // OIDNQuality
inline constexpr int kNoError = 0, kCancelled = 6;       // OIDNError
inline constexpr const char* kFile = "libOpenImageDenoise.so.2";

// KINDLING_OIDN_FUNCTIONS(FUNCTION): FUNCTION(result, member, "name in the library", parameters).
#define KINDLING_OIDN_FUNCTIONS(FUNCTION)                                                                              \
  FUNCTION(Device, new_device, "oidnNewDevice", (int type))                                                            \
  FUNCTION(void, set_device_int, "oidnSetDeviceInt", (Device device, const char* name, int value))                     \
  FUNCTION(int, get_device_int, "oidnGetDeviceInt", (Device device, const char* name))                                 \
  FUNCTION(void, commit_device, "oidnCommitDevice", (Device device))                                                   \
  FUNCTION(int, device_error, "oidnGetDeviceError", (Device device, const char** message))                             \
  FUNCTION(void, release_device, "oidnReleaseDevice", (Device device))                                                 \
  FUNCTION(Filter, new_filter, "oidnNewFilter", (Device device, const char* type))                                     \
  FUNCTION(void, set_image, "oidnSetSharedFilterImage",                                                                \
           (Filter filter, const char* name, void* data, int format, size_t width, size_t height, size_t offset,       \
            size_t pixel_stride, size_t row_stride))                                                                   \
  FUNCTION(void, set_bool, "oidnSetFilterBool", (Filter filter, const char* name, bool value))                         \
  FUNCTION(void, set_int, "oidnSetFilterInt", (Filter filter, const char* name, int value))                            \
  FUNCTION(void, set_progress, "oidnSetFilterProgressMonitorFunction", (Filter filter, Progress progress, void* user)) \
  FUNCTION(void, commit_filter, "oidnCommitFilter", (Filter filter))                                                   \
  FUNCTION(void, execute_filter, "oidnExecuteFilter", (Filter filter))                                                 \
  FUNCTION(void, release_filter, "oidnReleaseFilter", (Filter filter))

// All functions are set.
struct Library {
#define KINDLING_OIDN_MEMBER(result, member, name, parameters) result(*member) parameters = nullptr;
  KINDLING_OIDN_FUNCTIONS(KINDLING_OIDN_MEMBER)
#undef KINDLING_OIDN_MEMBER
  std::shared_ptr<void> handle;
  std::string file; // as it was opened
};

// Opens the library that the environment variable KINDLING_OIDN names, a file or a folder that has
// it or has it in lib/. Without the variable: that of the user
// ($XDG_DATA_HOME/kindling/oidn/lib, as cmake/get_oidn.sh installs it), of the library folder of
// Kindling, or of the system. Fails (render_failed) with how to get one if there is none, or if it
// lacks a function.
[[nodiscard]] Result<Library> open_library();

} // namespace kindling::oidn
