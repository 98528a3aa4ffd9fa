// The neutral environment of scenes without lights.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/environment.h"

#include <memory>

namespace kindling {

// Returns a gray studio: radiance 0.25 at the floor, 0.6 at the horizon and 0.9 at the zenith, with
// one large soft key light (6) high on the +x +z side and a dimmer fill light (2) opposite. All
// channels are equal.
[[nodiscard]] std::shared_ptr<const Environment> builtin_environment();

} // namespace kindling
