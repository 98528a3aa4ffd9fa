// Transmittance of a clear coat over an emitter (KHR_materials_clearcoat).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

namespace kindling {

// KHR_materials_clearcoat, "Emission": a coat of strength `clearcoat`, in [0, 1], attenuates the
// emission as well, by Schlick's Fresnel with 0.04 at normal incidence. cos_theta is between the
// direction and the geometric normal. The extension uses the coat's own normal, but light samples
// only know the geometric one, and hits must agree with them.
[[nodiscard]] inline float coat_transmittance(float clearcoat, float cos_theta) {
  const float grazing = std::clamp(1.0f - std::fabs(cos_theta), 0.0f, 1.0f);
  const float fifth = square(square(grazing)) * grazing;
  return 1.0f - clearcoat * (0.04f + 0.96f * fifth);
}

} // namespace kindling
