// The lens of a camera: how much of the scene is in focus, and what the rest is blurred into.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <optional>

namespace kindling {

// As photographers name it. The defaults are a pinhole, which everything is in focus for.
struct CameraLens {
  std::optional<float> f_stop; // N of f/N, above 0: the aperture is focal length / N wide; unset: a pinhole
  // Above 0; unset: that of a 24 mm high sensor (36 mm x 24 mm) with the field of view.
  std::optional<float> focal_length_m;
  // Above 0, along the axis: what is this far away is sharp; unset: by the focus point.
  std::optional<float> focus_distance_m;
  std::optional<V2f> focus_point; // what is seen there is sharp; fractions of the image from its upper left corner

  int aperture_blades = 0;            // 3 or more: a regular polygon; fewer: a disk
  float aperture_rotation_rad = 0.0f; // counter-clockwise, as the camera sees the highlights it makes
  float anamorphic_ratio = 1.0f;      // height over width of the aperture, whose height stays; above 0
  float cats_eye = 0.0f; // from 0 to 1: how much of the aperture the barrel hides in the corners of the image

  [[nodiscard]] bool is_pinhole() const { return !f_stop; }
};

} // namespace kindling
