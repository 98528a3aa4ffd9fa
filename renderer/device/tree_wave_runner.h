// Waves of the Whitted tracer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device_wave.h"
#include "renderer/device/kernels/tree_wave.h"
#include "renderer/integrator/whitted_settings.h"

#include <array>

namespace kindling {

// The kernels that its waves launch.
inline constexpr std::array kTreeWaveKernels{Kernel::begin_tree, Kernel::take_node, Kernel::trace_node,
                                             Kernel::finish_tree_pixel};

// Returns the bytes on a device that its waves take, at most.
[[nodiscard]] uint64_t tree_wave_bytes(const WaveSetup& setup, const WhittedSettings& settings);

class TreeWaveRunner final : public DeviceWave {
 public:
  TreeWaveRunner(Device& device, const World& world, const DeviceScene* scene, const WhittedSettings& settings,
                 const WaveSetup& setup);

  [[nodiscard]] bool run(const Film& film) override;

 private:
  // Returns how many of the waiting nodes to trace together, the newest ones; at least 1.
  [[nodiscard]] uint32_t round_size(uint32_t waiting) const;

  TreeWave wave_;
  uint32_t max_children_; // of a node
  uint32_t reserve_;      // places that only single nodes may fill
  DeviceArray<WhittedSample> sums_;
  DeviceArray<WhittedComponents> components_;
  DeviceArray<WhittedNode> waiting_, nodes_;
  DeviceArray<uint32_t> waiting_count_;
};

} // namespace kindling
