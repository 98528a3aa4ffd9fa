// An NVIDIA GPU as a device.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/device/device.h"

#include <memory>

namespace kindling {

// Returns true if the program was built with the kernels for GPUs, which takes clang-19.
[[nodiscard]] bool has_gpu_kernels();

// Opens the first GPU that can run the kernels. Its driver compiles each kernel when it is first
// needed (Device::prepare()), unless it has done so before; `notice`, which may be null, learns of
// it first. Fails (render_failed) if there is none.
[[nodiscard]] Result<std::unique_ptr<Device>> open_cuda_device(const DeviceNotice& notice);

} // namespace kindling
