// What a clear coat over an emitter lets through.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// KHR_materials_clearcoat, "Emission": the coat of strength `clearcoat`, [0, 1], covers the emission as well; Schlick's Fresnel with
// 0.04 at normal incidence. cos_theta: between the direction and the geometric normal. The extension asks for the coat's own
// normal; hits and light samples have to agree to the bit of meaning, and a sample of a light knows no other normal.
[[nodiscard]] inline float coat_transmittance(float clearcoat, float cos_theta) {
  const float grazing = std::clamp(1.0f - std::fabs(cos_theta), 0.0f, 1.0f);
  const float fifth = square(square(grazing)) * grazing;
  return 1.0f - clearcoat * (0.04f + 0.96f * fifth);
}

} // namespace kindling
