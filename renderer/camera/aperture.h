// The aperture of a lens: shape and uniform sampling.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/scene/camera_lens.h"

#include <cstdint>

namespace kindling {

// A disk or a regular polygon of at least 3 blades in the plane of the lens, x to the right and y
// up as seen by the camera; narrowed by the anamorphic ratio; vignetted by a round barrel that
// hides more of it towards the corners of the image (cat's eye). Highlights behind the plane of
// focus have its shape; in front of it the shape is rotated by half a circle.
class Aperture {
 public:
  // The corners of the polygon are on the circle of `radius_m`, the first at the top before the
  // rotation.
  Aperture(const CameraLens& lens, float radius_m);

  // Returns a point uniform by area on the unobstructed part, in meters. `field` is the position in
  // the image, from the center (0, 0) to corners of length 1, x to the right and y up. u in [0,
  // 1)^2; stratification is preserved where the barrel hides nothing. Hidden points are replaced by
  // others generated from the bits of u, so the result depends on the arguments alone.
  [[nodiscard]] V2f sample(const V2f& u, const V2f& field) const;
  // True if the barrel hides a point of the aperture from a place in the image.
  [[nodiscard]] bool hides(const V2f& point_m, const V2f& field) const {
    return is_hidden({point_m.x / (radius_ * width_over_height_), point_m.y / radius_}, field);
  }
  // Returns an estimate of the area of the whole aperture over that of the part that the barrel
  // leaves, at least 1, with the right mean: how many points of the aperture are drawn until one is
  // not hidden. A function of its arguments.
  [[nodiscard]] float area_ratio(uint32_t key, const V2f& field) const;
  // True if sample() can return this point, up to rounding at the edge.
  [[nodiscard]] bool contains(const V2f& point_m, const V2f& field) const;
  // Returns the radius of a circle of the same vertical extent, before the anamorphic ratio.
  [[nodiscard]] float radius() const { return radius_; }
  [[nodiscard]] bool has_cats_eye() const { return cats_eye_ > 0.0f; } // sample() depends on the field
  [[nodiscard]] float width_over_height() const { return width_over_height_; }

 private:
  // Points on the unit circle's scale, before the ratio.
  [[nodiscard]] V2f sample_shape(const V2f& u) const;
  [[nodiscard]] V2f next_point(uint32_t& key) const;
  [[nodiscard]] bool is_hidden(const V2f& point, const V2f& field) const {
    return cats_eye_ > 0.0f && (point - barrel_center(field)).length2() > 1.0f;
  }
  [[nodiscard]] V2f barrel_center(const V2f& field) const;

  float radius_;
  float width_over_height_; // 1 / anamorphic ratio
  float cats_eye_;
  int blades_ = 0;                          // 0: disk
  float first_corner_ = 0.0f;               // turns from +x
  float step_cos_ = 1.0f, step_sin_ = 0.0f; // from corner to corner
  float inner_radius_ = 1.0f;               // of the inscribed circle of the polygon
};

} // namespace kindling
