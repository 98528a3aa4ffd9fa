// Waves of ambient occlusion and of the debug views.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device_wave.h"
#include "renderer/device/kernels/first_hit_wave.h"

#include <array>

namespace kindling {

// The kernels that its waves launch.
inline constexpr std::array kFirstHitWaveKernels{Kernel::show_first_hit, Kernel::finish_first_hit_pixel};

// Returns the bytes on a device that its waves take, at most.
[[nodiscard]] uint64_t first_hit_wave_bytes(const WaveSetup& setup);

class FirstHitWaveRunner final : public DeviceWave {
 public:
  FirstHitWaveRunner(Device& device, const World& world, const DeviceScene* scene, const WaveSetup& setup);

  [[nodiscard]] bool run(const Film& film) override;

 private:
  FirstHitWave wave_;
  DeviceArray<SampleColor> colors_;
};

} // namespace kindling
