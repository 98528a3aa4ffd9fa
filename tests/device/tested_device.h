// The device that tests compare with the CPU.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/make_device.h"

#include <cstdlib>
#include <memory>
#include <string_view>
#include <utility>

namespace kindling::test {

// The host device, or a GPU if KINDLING_TESTED_DEVICE in the environment is "gpu".
inline DeviceKind tested_device() {
  const char* const name = std::getenv("KINDLING_TESTED_DEVICE");
  return name != nullptr && std::string_view(name) == "gpu" ? DeviceKind::gpu : DeviceKind::host;
}

// `threads`: of the host device. Ends the test program if there is no such device.
inline std::unique_ptr<Device> make_tested_device(int threads) {
  return std::move(open_device(tested_device(), threads, nullptr)).value();
}

} // namespace kindling::test
