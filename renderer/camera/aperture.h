// The opening of a lens: its shape, and points on it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/scene/camera_lens.h"

namespace kindling {

// A disk or a regular polygon of 3 and more blades in the plane of the lens, x to the right and y up as the camera looks; made narrower
// by the anamorphic ratio; seen through a round barrel that hides more of it the farther from the middle of the image (cat's eye). Highlights
// behind the plane of focus have its shape, those in front of it the shape turned by half a circle.
class Aperture {
 public:
  // Corners of the polygon are on the circle of `radius_m`, the first at the top before the rotation.
  Aperture(const CameraLens& lens, float radius_m);

  // Uniform by area over what the barrel leaves open; meters. `field`: where in the image, from the middle (0, 0) to corners of length 1,
  // x to the right and y up. u in [0, 1)^2; stratification is kept where the barrel hides nothing. The points that it hides are replaced by others
  // that are made of the bits of u, so the answer depends on the arguments alone.
  [[nodiscard]] V2f sample(const V2f& u, const V2f& field) const;
  // Whether sample() can give this point, up to rounding at the edge.
  [[nodiscard]] bool contains(const V2f& point_m, const V2f& field) const;
  // Of a circle of the same extent up and down, before the anamorphic ratio.
  [[nodiscard]] float radius() const { return radius_; }
  [[nodiscard]] float width_over_height() const { return width_over_height_; }

 private:
  [[nodiscard]] V2f sample_shape(const V2f& u) const; // on the unit circle's scale, before the ratio
  [[nodiscard]] V2f barrel_center(const V2f& field) const;

  float radius_;
  float width_over_height_; // 1 / anamorphic ratio
  float cats_eye_;
  int blades_ = 0;                          // 0: a disk
  float first_corner_ = 0.0f;               // turns from +x
  float step_cos_ = 1.0f, step_sin_ = 0.0f; // from corner to corner
  float inner_radius_ = 1.0f;               // of the circle inside the polygon
};

} // namespace kindling
