// Ray cone: the footprint of a ray, which grows linearly with distance.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kindling {

// A cone around a ray (Akenine-Moeller et al. 2021, "Improved Shader and Texture Level of Detail
// Using Ray Cones").
struct RayCone {
  float width_m = 0.0f; // diameter at the origin of the ray
  float spread = 0.0f;  // growth of the diameter per meter; for narrow cones, the full opening angle in radians

  // Returns the diameter, in meters, at a distance from the origin.
  [[nodiscard]] float width_at(float distance_m) const { return width_m + spread * distance_m; }
};

} // namespace kindling
