// The neutral environment of a scene that brings no light of its own.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/light/environment.h"

#include <memory>

namespace kindling {

// A gray studio: floor 0.25, horizon 0.6 and zenith 0.9 of radiance, with one large soft key light (6) high on the +x +z side
// and a dimmer fill (2) opposite, so that shapes read. The same numbers in every channel.
[[nodiscard]] std::shared_ptr<const Environment> builtin_environment();

} // namespace kindling
