// Options for the sizes of lights that the file leaves out.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace kindling::app {

// Sizes of lights that have none in the file. Unset: they stay points and directions.
struct LightOptions {
  std::optional<double> radius_m;      // point and spot lights, measured luminaires included
  std::optional<double> sun_angle_deg; // angular diameter of directional lights
};

} // namespace kindling::app
