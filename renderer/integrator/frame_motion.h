// The frames before and after an image, for motion vectors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/camera/camera.h"
#include "renderer/scene/surface_motion.h"

namespace kindling {

struct FrameMotion {
  struct Frame {
    SurfaceMotion surfaces; // from the time of the image
    Camera camera;          // for an image of the same size
  };
  Frame previous, next;
};

} // namespace kindling
