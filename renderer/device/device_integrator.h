// All integrators on a device: the images of the CPU, to the bit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"
#include "renderer/device/device_wave.h"
#include "renderer/device/scene_on_device.h"
#include "renderer/device/tile_pager.h"
#include "renderer/integrator/first_hits.h"
#include "renderer/integrator/integrator.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace kindling {

// One thread at a time may render with it, since a device takes calls of one thread.
class DeviceIntegrator final : public Integrator {
 public:
  // Copies the scene and prepares the kernels. Throws DeviceError. The Whitted tracer has its
  // iterative form. The device and the world must outlive this. Paths and pager of `setup` follow
  // from the device's memory, its first hits from `first_hits`, which may be null: none are
  // recorded.
  DeviceIntegrator(Device& device, const IntegratorSettings& settings, const DeviceSceneInput& input,
                   const WaveSetup& setup, std::unique_ptr<const FirstHits> first_hits = nullptr);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                        Film& film) const override;
  [[nodiscard]] uint32_t samples_per_pass() const override;
  [[nodiscard]] uint64_t paths_together() const override { return setup_.paths; }
  [[nodiscard]] bool on_device() const override { return true; }
  void render_blocks(std::span<BlockWork> work, ThreadContext& context, Film& film) const override;
  [[nodiscard]] size_t scene_bytes() const { return scene_->bytes(); } // without texture tiles
  // Counts since the start.
  [[nodiscard]] TileStatistics tile_statistics() const { return pager_ ? pager_->statistics() : TileStatistics{}; }

 private:
  [[nodiscard]] uint64_t wave_bytes(uint32_t paths) const;
  // Renders the samples of the blocks in this range, or levels. False if the World was abandoned.
  [[nodiscard]] static bool render_samples(std::span<BlockWork> work, const SampleRange& samples, DeviceWave& wave,
                                           Film& film);

  Device& device_;
  IntegratorSettings settings_;
  const World& world_;
  WaveSetup setup_;
  std::unique_ptr<const FirstHits> first_hits_;
  std::unique_ptr<TilePager> pager_; // null: all texels are in memory
  std::optional<SceneOnDevice> scene_;
};

} // namespace kindling
