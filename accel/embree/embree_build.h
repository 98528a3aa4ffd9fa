// Embree scenes built from a BuildInput: one per transformed group, and a top scene.
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

// Identifies a geometry of the top scene: one mesh of an instance with identity transform, or a
// whole instance whose first mesh is geometry 0 of the group's scene. Without an instance: the
// persistent scene.
struct NamedGeometry {
  uint32_t instance = kNoId;
  uint32_t mesh = kNoId;
};
struct GeometryNames {
  std::vector<NamedGeometry> top;        // by geometry id in the top scene
  std::vector<NamedGeometry> persistent; // by geometry id in the persistent scene
};

// The device of the scenes.
struct DeviceScenes {
  // Bytes that the device holds. Embree updates the counter until the device is released, so it
  // must outlive the device.
  std::unique_ptr<std::atomic<int64_t>> memory_bytes;
  std::optional<SimdTarget> simd; // the instruction set requested
  Device device;
};

// Functions that Embree calls with candidates: `cutout` for meshes that are not opaque, `opaque`
// for the others. Either may be null.
struct Filters {
  RTCFilterFunctionN cutout = nullptr, opaque = nullptr;

  bool operator==(const Filters& other) const = default;
};

// Scenes over persistent meshes that one accelerator leaves to the next.
struct PersistentScenes final : PersistentStructures {
  Quality quality = Quality::balanced;
  bool robust = true;
  Filters filters; // with which they were built
  DeviceScenes on;
  StructureStore<Scene> scenes;
};

struct BuiltScenes {
  DeviceScenes on;
  std::vector<Scene> groups;                  // by group; empty if no transformed instance uses it
  std::vector<PersistentMeshes> group_meshes; // by group
  // Persistent meshes under identity transforms: an instance in the top scene or, if there is
  // nothing else, the top scene itself.
  Scene persistent;
  PersistentMeshes persistent_meshes;
  std::vector<std::unique_ptr<GuardedInstance>> guarded; // used by the top scene, which they must outlive
  Scene own_top;                                         // empty if `persistent` is the top scene
  float ray_extent = kMaxCoordinate;                     // see is_traceable()
  GeometryNames names;
  size_t triangle_count = 0;       // counted once per instance
  size_t built_triangle_count = 0; // in scenes built this time, each counted once

  [[nodiscard]] RTCScene top() const { return own_top ? own_top.get() : persistent.get(); }
};

// Returns false if cancelled. `previous` may be null. Throws std::bad_alloc.
[[nodiscard]] bool build_scenes(const BuildInput& input, const BuildOptions& options, const Filters& filters,
                                std::unique_ptr<PersistentScenes> previous, BuiltScenes& out);

} // namespace kindling::accel::embree
