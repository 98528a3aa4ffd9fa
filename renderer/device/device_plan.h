// Division of a device's memory among the scene, paths and texture tiles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"
#include "renderer/device/scene_on_device.h"
#include "renderer/device/tile_plan.h"

#include <cstdint>
#include <functional>
#include <optional>

namespace kindling {

// Waves of fewer paths are not made.
inline constexpr uint32_t kMinWaveSize = 1U << 12;

struct DevicePlan {
  uint32_t paths = kWaveSize;    // of a wave
  std::optional<TilePlan> tiles; // unset: all texels are in memory
  uint32_t slots = 0;            // for tiles
  uint32_t photon_maps = 1;      // at the same time
};

// Photon maps of a render, all of the same size.
struct PhotonMapNeeds {
  uint64_t bytes = 0;    // of a map; 0: none are gathered
  uint32_t together = 1; // that the largest waves can use
};

// Keeps all texels in memory if they fit beside waves of a sixteenth of Device::wave_size(); else
// waves take at most a quarter of what the scene without its tiles leaves, and tiles the rest.
// Several photon maps are there only beside all texels and the largest waves, else one.
// `wave_bytes(paths)`: of the tracer's waves. Throws DeviceError with the figures if there is no
// room even for the smallest waves and the tiles of one surface.
[[nodiscard]] DevicePlan plan_device_memory(const Device& device, const DeviceSceneInput& input,
                                            const std::function<uint64_t(uint32_t)>& wave_bytes,
                                            const PhotonMapNeeds& photons = {});

} // namespace kindling
