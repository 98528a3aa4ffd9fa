// Measures a device, and a device and the processor that share a frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/app/scaling/scaling_measure.h"
#include "renderer/app/scaling/scaling_report.h"
#include "renderer/base/result.h"
#include "renderer/device/make_device.h"
#include "renderer/film/film.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace kindling::app {

// Fails, as a render does, if the device cannot be opened. Returns its name. A GPU's kernels are
// compiled by this; `notice` learns of it first.
[[nodiscard]] Result<std::string> try_device(DeviceKind kind, const DeviceNotice& notice);

// Measures one render on the device; its accelerator is a kd-tree. `threads`: of the host device.
[[nodiscard]] Result<DeviceSample> measure_device(const ScalingStage& stage, const RenderOptions& options,
                                                  uint32_t samples_per_pixel, DeviceKind device, int threads);

// Measures one frame whose upper part the processor renders, on `threads` threads, while the device
// renders the rest; then the parts are merged. `share`: of the processor, by blocks of rows, which
// leaves each side at least one.
[[nodiscard]] Result<SharedSample> measure_shared(const ScalingStage& stage, const RenderOptions& options,
                                                  uint32_t samples_per_pixel, DeviceKind device, int threads,
                                                  double share);

// Divides a crop between processor (first) and device by whole blocks of rows, which both get at
// least one of; nothing if there is only one.
[[nodiscard]] std::optional<std::pair<PixelRect, PixelRect>> divide_rows(const PixelRect& crop, double share);

// The share of the processor with which both sides end together: by the rates at which they have
// rendered the last shared frame, and before the first one a frame each. `threads_s`: that of the
// processor with the threads of a shared frame.
[[nodiscard]] double balanced_share(const DeviceScaling& device, double threads_s);

} // namespace kindling::app
