// Records of the first surface of each sample in films: ids for mattes, and the nearest sample.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/film/film.h"
#include "renderer/integrator/aov_inputs.h"
#include "renderer/integrator/motion_vectors.h"
#include "renderer/integrator/stages/camera_sample.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/scene/surface_names.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace kindling {

// Immutable and shared by all threads. The world, the camera and the inputs must outlive it.
class FirstHits {
 public:
  FirstHits(const World& world, const Camera& camera, const PixelFilter& filter, AovSet aovs, const AovInputs& inputs);

  // False if no AOV needs first hits, and add() is not to be called.
  [[nodiscard]] bool wanted() const { return wanted_; }
  // Adds the first surface of a sample, the one that its path does not pass straight through; no
  // hit if there is none. The ids count with the sample's filter weight.
  void add(const CameraSample& sample, const accel::Hit& hit, Film& film) const;

 private:
  [[nodiscard]] MatteIds ids_at(const accel::Hit& hit) const;
  [[nodiscard]] NearestSample describe(const CameraSample& sample, const accel::Hit& hit) const;

  struct NodeIds {
    uint32_t object = 0, asset = 0;
  };
  const World& world_;
  const Camera& camera_;
  PixelFilter filter_;
  bool wanted_, nearest_;
  std::optional<MotionVectors> motion_;
  std::vector<NodeIds> nodes_;      // by node; empty without mattes; 0 for mattes that are not wanted
  std::vector<uint32_t> materials_; // by material, the default one last; likewise
};

} // namespace kindling
