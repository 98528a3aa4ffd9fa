// Lens parameters of a camera: aperture, focal length and focus.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <optional>

namespace kindling {

// Photographic lens parameters. The default is a pinhole, which has everything in focus.
struct CameraLens {
  std::optional<float> f_stop; // N of f/N, above 0: the aperture diameter is focal length / N; unset: pinhole
  // Above 0. Unset: the focal length that gives the field of view on a 24 mm high sensor (36 x 24
  // mm).
  std::optional<float> focal_length_m;
  // Distance of the plane of focus along the axis, above 0. Unset: determined by the focus point.
  std::optional<float> focus_distance_m;
  std::optional<V2f> focus_point; // focuses on the surface seen here; fractions of the image from its upper left corner

  int aperture_blades = 0;            // 3 or more: a regular polygon; fewer: a disk
  float aperture_rotation_rad = 0.0f; // counterclockwise, as highlights appear to the camera
  float anamorphic_ratio = 1.0f;      // height over width of the aperture at constant height; above 0
  float cats_eye = 0.0f; // [0, 1]: how strongly the barrel vignettes the aperture in the corners of the image

  [[nodiscard]] bool is_pinhole() const { return !f_stop; }
};

} // namespace kindling
