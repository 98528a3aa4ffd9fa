// Names of the kinds of devices, and the choice among them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/make_device.h"

#include "renderer/device/cuda/cuda_device.h"
#include "renderer/device/host_device.h"

#include <cassert>

namespace kindling {

std::string_view device_kind_name(DeviceKind kind) {
  switch (kind) {
  case DeviceKind::cpu: return "cpu";
  case DeviceKind::host: return "host";
  case DeviceKind::gpu: return "gpu";
  case DeviceKind::automatic: return "auto";
  }
  return "unknown";
}

std::optional<DeviceKind> device_kind_from_name(std::string_view name) {
  for (const DeviceKind kind : kDeviceKinds)
    if (device_kind_name(kind) == name) return kind;
  return std::nullopt;
}

Result<std::unique_ptr<Device>> open_device(DeviceKind kind, int threads, const DeviceNotice& notice) {
  assert(needs_device(kind));
  if (kind == DeviceKind::gpu) return open_cuda_device(notice);
  return make_host_device(threads);
}

} // namespace kindling
