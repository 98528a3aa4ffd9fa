// A ray with a width: how much of the scene one sample stands for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kindling {

// Akenine-Moeller et al. 2021, "Improved Shader and Texture Level of Detail Using Ray Cones". Around a ray, growing linearly.
struct RayCone {
  float width_m = 0.0f; // diameter where the ray starts
  float spread = 0.0f;  // growth of the diameter per meter: for small angles, the angle between opposite sides

  [[nodiscard]] float width_at(float distance_m) const { return width_m + spread * distance_m; }
};

} // namespace kindling
