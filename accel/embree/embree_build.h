// Builds Embree's scenes from a BuildInput: one scene per moved group, one top scene for everything.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "accel/embree/embree_api.h"
#include "accel/embree/embree_guarded.h"
#include "accel/persistent_meshes.h"
#include "accel/triangle.h"

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

namespace kindling::accel::embree {

// What a geometry of the top scene stands for: one mesh of an instance with identity transform, or the whole instance,
// whose first mesh has geometry 0 of the group's scene. No instance: the scene of what lasts.
struct NamedGeometry {
  uint32_t instance = kNoId;
  uint32_t mesh = kNoId;
};
struct GeometryNames {
  std::vector<NamedGeometry> top;     // by geometry id in the top scene
  std::vector<NamedGeometry> lasting; // by geometry id in the scene of what lasts
};

// With the device that they live on.
struct DeviceScenes {
  // Bytes that the device holds; updated by Embree until the device is gone, so it must outlive it.
  std::unique_ptr<std::atomic<int64_t>> memory_bytes;
  std::optional<SimdTarget> simd; // that was asked for
  Device device;
};

// The scenes that one accelerator leaves to the next.
struct PersistentScenes final : PersistentStructures {
  Quality quality = Quality::balanced;
  bool robust = true, filtered = false; // with a hit filter
  DeviceScenes on;
  KeptBy<Scene> scenes;
};

struct BuiltScenes {
  DeviceScenes on;
  std::vector<Scene> groups;                  // by group; empty where no moved instance uses it
  std::vector<PersistentMeshes> group_meshes; // likewise
  // What lasts under identity transforms, an instance in the top scene unless nothing else is there: then it is the top scene.
  Scene lasting;
  PersistentMeshes persistent_meshes;
  std::vector<std::unique_ptr<GuardedInstance>> guarded; // in the top scene, which they must outlive
  Scene own_top;                                         // empty where `lasting` serves
  float ray_extent = kLargestCoordinate;                 // see is_traceable()
  GeometryNames names;
  size_t triangle_count = 0;       // each instance counts
  size_t built_triangle_count = 0; // of scenes that were not kept, each once

  [[nodiscard]] RTCScene top() const { return own_top ? own_top.get() : lasting.get(); }
};

// False if cancelled. `filter` is attached to the meshes that are not opaque. `kept` may be null. Throws std::bad_alloc.
[[nodiscard]] bool build_scenes(const BuildInput& input, const BuildOptions& options, RTCFilterFunctionN filter,
                                std::unique_ptr<PersistentScenes> kept, BuiltScenes& out);

} // namespace kindling::accel::embree
