// The processor as a device: the kernels compiled by the host's compiler, in a shuffled order.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"

#include <memory>

namespace kindling {

// It is for tests: what a kernel computes must not depend on the order, and this device makes sure
// that the order is not the obvious one. `threads` is at least 1.
[[nodiscard]] std::unique_ptr<Device> make_host_device(int threads);

} // namespace kindling
