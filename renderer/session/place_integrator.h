// The integrator of a render, and the device that it runs on.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/camera/camera.h"
#include "renderer/device/device_integrator.h"
#include "renderer/device/metered_device.h"
#include "renderer/integrator/integrator.h"
#include "renderer/session/render_session.h"
#include "renderer/world/world.h"

#include <memory>
#include <string>

namespace kindling {

[[nodiscard]] Sampler make_sampler(const RenderSettings& settings);

// `device` is null for the CPU; with DeviceKind::automatic `why_cpu` then tells the reason in
// words.
struct OpenedDevice {
  std::unique_ptr<MeteredDevice> device;
  std::string why_cpu;
};

// Opens the device of a render whose settings have passed check_settings(). DeviceKind::automatic
// takes the GPU if it can be opened and renders the world with these settings, else the CPU. Fails
// on what the device that is asked for cannot do (usage), and if it cannot be opened
// (render_failed). `threads`: at least 1. `notice` may be null.
[[nodiscard]] Result<OpenedDevice> open_device(const World& world, const Camera& camera, const RenderSettings& settings,
                                               int threads, const DeviceNotice& notice);

struct PlacedIntegrator {
  std::unique_ptr<MeteredDevice> device; // null for the CPU
  std::unique_ptr<Integrator> integrator;
  const DeviceIntegrator* on_device = nullptr; // the same one; null for the CPU
  DeviceUse use;

  // Adds the counts of what has been rendered to `seen`.
  void count(DeviceUse& seen) const;
};

// Throws DeviceError if the device has no room for the scene; DeviceKind::automatic takes the CPU
// then.
[[nodiscard]] PlacedIntegrator place_integrator(OpenedDevice opened, const World& world, const Camera& camera,
                                                const RenderSettings& settings, const Guide* guide);

} // namespace kindling
