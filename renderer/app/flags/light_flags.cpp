// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/light_flags.h"

#include "renderer/app/flags/flag_set.h"
#include "renderer/app/text/parse_values.h"

namespace kindling::app {

void add_light_flags(FlagSet& flags, LightOptions& o) {
  flags.value("--light-radius", "METRES",
              "Radius of point and spot lights whose file gives them none: soft shadows [0]",
              [&o](auto text) { return store(parse_number(text, 0.0, 1e9), o.radius_m); });
  flags.value("--sun-angle", "DEG",
              "Diameter of directional lights whose file gives them none, degrees; the sun's is 0.53 [0]",
              [&o](auto text) { return store(parse_number(text, 0.0, 180.0), o.sun_angle_deg); });
}

} // namespace kindling::app
