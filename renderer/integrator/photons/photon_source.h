// The photon maps of a render that one thread leads, such as that of a device.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/integrator.h"
#include "renderer/integrator/light_paths/light_paths.h"
#include "renderer/integrator/photons/photon_maps.h"
#include "renderer/world/light_groups/light_groups.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include <cstdint>
#include <memory>

namespace kindling {

// Traces maps when they are asked for: those of PathIntegrator, to the bit. One thread at a time
// may call it.
class PhotonSource {
 public:
  // `light_paths` leave photons; `stages` are those of the camera's paths beside them, on the
  // processor. `threads`: that trace, at least 1. `groups`: of the photons' light. The world and
  // the camera must outlive this.
  PhotonSource(const PathStages& stages, std::unique_ptr<const LightPaths> light_paths, const World& world, int threads,
               LightGroups groups = {});
  PhotonSource(const PhotonSource&) = delete;
  PhotonSource& operator=(const PhotonSource&) = delete;

  [[nodiscard]] const PhotonMaps& maps() const { return maps_; }
  // Returns the map of a sample; null if the World was abandoned. Counts the rays that it has cost.
  [[nodiscard]] PhotonMaps::Map of_sample(uint32_t sample, RayCounters& counters);

 private:
  // The paths and counts of a thread that traces.
  struct Context {
    LightPathContext paths;
    RayCounters rays;
  };

  PathStages stages_;
  std::unique_ptr<const LightPaths> light_paths_;
  const World& world_;
  LightGroups groups_;
  LightGroupsView groups_view_;
  PhotonMaps maps_;
  tbb::task_arena arena_;
  tbb::enumerable_thread_specific<Context> contexts_;
};

} // namespace kindling
