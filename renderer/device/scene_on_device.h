// A scene in the memory of a device, for the kernels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"
#include "renderer/device/device.h"
#include "renderer/device/kernels/device_scene.h"
#include "renderer/device/tile_pager.h"
#include "renderer/guiding/guide.h"
#include "renderer/world/world.h"

#include <cstddef>
#include <cstdint>

namespace kindling {

// The parts of a scene on a device. References must live while the scene is made, no longer.
struct DeviceSceneInput {
  const World& world; // its accelerator is a kd-tree
  const CameraView& camera;
  const PathStages& stages;        // made for the same world, camera and guide, in the processor's memory
  const WhittedShader& shader;     // likewise
  const FirstHitStages& first_hit; // likewise
  Sampler sampler;
  PixelFilter filter;
  const LightPathStages* light_paths = nullptr; // null: stages.light_paths is, too
  LightGroupsView groups{};
};

// Fails (usage) if no device can render the world, with the reason.
[[nodiscard]] Result<void> check_device_scene(const World& world);

// Returns the bytes of the scene on a device, without the levels of textures that are in tiles;
// null: with all.
[[nodiscard]] uint64_t scene_on_device_bytes(const DeviceSceneInput& input, const TilePlan* tiles);

class SceneOnDevice {
 public:
  // Throws DeviceError if the device has no room. The input has passed check_device_scene().
  // `pager` has the textures in tiles; null: all texels are placed.
  SceneOnDevice(Device& device, const DeviceSceneInput& input, const TilePager* pager = nullptr);

  [[nodiscard]] const DeviceScene* address() const { return reinterpret_cast<const DeviceScene*>(memory_.data()); }
  [[nodiscard]] size_t bytes() const { return memory_.size(); }

 private:
  DeviceArray<std::byte> memory_;
};

} // namespace kindling
