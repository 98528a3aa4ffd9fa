// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/light_flags.h"

#include "renderer/app/flag_set.h"
#include "renderer/app/parse_values.h"
#include "renderer/scene/scene.h"

namespace kindling::app {

void add_light_flags(FlagSet& flags, LightOptions& o) {
  flags.value("--light-radius", "METRES",
              "Radius of point and spot lights whose file gives them none: soft shadows [0]",
              [&o](auto text) { return store(parse_number(text, 0.0, 1e9), o.radius_m); });
  flags.value("--sun-angle", "DEG",
              "Diameter of directional lights whose file gives them none, degrees; the sun's is 0.53 [0]",
              [&o](auto text) { return store(parse_number(text, 0.0, 180.0), o.sun_angle_deg); });
}

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

} // namespace kindling::app
