// Motion of the surfaces of first hits, in pixels.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/film/nearest_sample.h"
#include "renderer/integrator/frame_motion.h"
#include "renderer/world/world.h"

#include <cstdint>
#include <vector>

namespace kindling {

// Immutable and shared by all threads. References given at construction must outlive it.
class MotionVectors {
 public:
  MotionVectors(const World& world, const Camera& camera, const FrameMotion& motion);

  // Sets the vectors of the surface at `hit`, whose position is given. What follows the camera's
  // movement alone, the background, moves by its direction.
  void measure(const accel::Hit& hit, const V3f& position, NearestSample& sample) const;
  void measure_background(const V3f& direction, NearestSample& sample) const;

 private:
  const World& world_;
  const Camera& camera_;
  const FrameMotion& motion_;
  std::vector<uint32_t> primitives_; // by geometry: its number among those of its node
};

} // namespace kindling
