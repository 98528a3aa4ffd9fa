// All integrators on a device: the images of the CPU, to the bit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"
#include "renderer/device/device_wave.h"
#include "renderer/device/scene_on_device.h"
#include "renderer/device/tile_pager.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace kindling {

// One thread at a time may render with it, since a device takes calls of one thread.
class DeviceIntegrator final : public Integrator {
 public:
  // Copies the scene and prepares the kernels. Throws DeviceError. The Whitted tracer has its
  // iterative form. The device and the world must outlive this. Paths and pager of `setup` follow
  // from the device's memory.
  DeviceIntegrator(Device& device, const IntegratorSettings& settings, const DeviceSceneInput& input,
                   const WaveSetup& setup);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                        Film& film) const override;
  [[nodiscard]] uint64_t paths_together() const override { return setup_.paths; }
  void render_blocks(std::span<BlockWork> work, ThreadContext& context, Film& film) const override;
  [[nodiscard]] size_t scene_bytes() const { return scene_->bytes(); } // without texture tiles
  // Counts since the start.
  [[nodiscard]] TileStatistics tile_statistics() const { return pager_ ? pager_->statistics() : TileStatistics{}; }

 private:
  [[nodiscard]] uint64_t wave_bytes(uint32_t paths) const;

  Device& device_;
  IntegratorSettings settings_;
  const World& world_;
  WaveSetup setup_;
  std::unique_ptr<TilePager> pager_; // null: all texels are in memory
  std::optional<SceneOnDevice> scene_;
};

} // namespace kindling
