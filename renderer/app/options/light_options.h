// Sizes of lights that the file does not give.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace kindling::app {

// Sizes of the lights whose file gives them none; unset: they have none.
struct LightOptions {
  std::optional<double> radius_m;      // of point and spot lights, measured luminaires included
  std::optional<double> sun_angle_deg; // of directional lights, across
};

} // namespace kindling::app
