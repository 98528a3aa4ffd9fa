// Flags of the lights that a scene brings along.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace kindling {
struct Scene;
}

namespace kindling::app {

class FlagSet;

// Sizes of the lights whose file gives them none; unset: they have none.
struct LightOptions {
  std::optional<double> radius_m;      // of point and spot lights, measured luminaires included
  std::optional<double> sun_angle_deg; // of directional lights, across
};

void add_light_flags(FlagSet& flags, LightOptions& options);

// What the file says of a light, 0 included, comes before the flags.
void apply_light_options(const LightOptions& options, Scene& scene);

} // namespace kindling::app
