// The kinds of devices that a render can run on, and their opening.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/device/device.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

namespace kindling {

enum class DeviceKind : uint8_t {
  cpu,       // the integrators, without a Device
  host,      // the kernels of a GPU, on the processor: for tests
  gpu,       // an NVIDIA GPU
  automatic, // a GPU if there is one that can render the image, else the CPU
};
inline constexpr std::array kDeviceKinds{DeviceKind::cpu, DeviceKind::host, DeviceKind::gpu, DeviceKind::automatic};

// Returns whether a render fails without a Device.
[[nodiscard]] constexpr bool needs_device(DeviceKind kind) {
  return kind == DeviceKind::host || kind == DeviceKind::gpu;
}

[[nodiscard]] std::string_view device_kind_name(DeviceKind kind);
[[nodiscard]] std::optional<DeviceKind> device_kind_from_name(std::string_view name);

// Opens a device; `kind` is host or gpu. `threads`: of the host device, at least 1. `notice` may be
// null; what it refers to must outlive the device.
[[nodiscard]] Result<std::unique_ptr<Device>> open_device(DeviceKind kind, int threads, const DeviceNotice& notice);

} // namespace kindling
