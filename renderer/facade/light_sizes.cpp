// Applies sizes to punctual lights.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/light_sizes.h"

#include "renderer/scene/scene.h"

namespace kindling {

void apply_light_options(const LightOptions& options, Scene& scene) {
  for (PunctualLight& light : scene.lights) {
    if (light.kind == PunctualLight::Kind::directional) {
      if (options.sun_angle_deg && !light.angular_diameter_rad)
        light.angular_diameter_rad = static_cast<float>(*options.sun_angle_deg) * (kPi / 180.0f);
    } else if (options.radius_m && !light.radius_m) {
      light.radius_m = static_cast<float>(*options.radius_m);
    }
  }
}

} // namespace kindling
