// All integrators on a device: the images of the CPU, to the bit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/device.h"
#include "renderer/device/scene_on_device.h"
#include "renderer/integrator/integrator.h"

namespace kindling {

// One thread at a time may render with it, since a device takes calls of one thread.
class DeviceIntegrator final : public Integrator {
 public:
  // Copies the scene and prepares the kernels. Throws DeviceError. The Whitted tracer has its
  // iterative form. The device and the world must outlive this.
  DeviceIntegrator(Device& device, const IntegratorSettings& settings, const DeviceSceneInput& input, AovSet aovs);

  [[nodiscard]] std::unique_ptr<ThreadContext> make_context() const override;
  uint32_t render_block(const PixelRect& block, const SampleRange& samples, ThreadContext& context,
                        Film& film) const override;
  [[nodiscard]] uint64_t paths_together() const override { return device_.wave_size(); }
  void render_blocks(std::span<BlockWork> work, ThreadContext& context, Film& film) const override;
  [[nodiscard]] size_t scene_bytes() const { return scene_.bytes(); }

 private:
  Device& device_;
  IntegratorSettings settings_;
  const World& world_;
  AovSet aovs_;
  SceneOnDevice scene_;
};

} // namespace kindling
