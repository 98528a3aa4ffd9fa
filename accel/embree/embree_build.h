// Builds Embree's scenes from a BuildInput: one scene per moved group, one top scene for everything.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/embree/embree_api.h"

#include <atomic>
#include <memory>
#include <vector>

namespace kindling::accel::embree {

// What a geometry of the top scene stands for: one mesh of an instance with identity transform, or the whole instance,
// whose first mesh has geometry 0 of the group's scene.
struct TopGeometry {
  uint32_t instance = kNoId;
  uint32_t mesh = kNoId;
};

struct BuiltScenes {
  // Bytes that the device holds; updated by Embree until the device is gone, so it must outlive it.
  std::unique_ptr<std::atomic<int64_t>> memory_bytes;
  Device device;
  std::vector<Scene> groups; // by group; empty where no moved instance uses it
  Scene top;
  std::vector<TopGeometry> top_geometries; // by geometry id in the top scene
  size_t triangle_count = 0;               // each instance counts
};

// False if cancelled. `filter` is attached to the meshes that are not opaque. Throws std::bad_alloc.
[[nodiscard]] bool build_scenes(const BuildInput& input, const BuildOptions& options, RTCFilterFunctionN filter,
                                BuiltScenes& out);

} // namespace kindling::accel::embree
