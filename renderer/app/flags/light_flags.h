// Flags of the lights that a scene brings along.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/image_settings.h"

namespace kindling::app {

class FlagSet;

void add_light_flags(FlagSet& flags, LightOptions& options);

} // namespace kindling::app
