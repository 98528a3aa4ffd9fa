// The neutral environment of scenes without lights, and the choice of using it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/environment.h"

#include <memory>
#include <optional>
#include <string_view>

namespace kindling {

// Use of the built-in environment. It takes the place of an environment of the file.
enum class Studio : uint8_t {
  off,
  on,
  automatic // for scenes without other light: World::lit_by_emission_alone()
};
[[nodiscard]] std::string_view studio_name(Studio studio); // "off", "on", "auto"
[[nodiscard]] std::optional<Studio> studio_from_name(std::string_view name);

// Returns a gray studio: radiance 0.25 at the floor, 0.6 at the horizon and 0.9 at the zenith, with
// one large soft key light (6) high on the +x +z side and a dimmer fill light (2) opposite. All
// channels are equal.
[[nodiscard]] std::shared_ptr<const Environment> builtin_environment();

} // namespace kindling
