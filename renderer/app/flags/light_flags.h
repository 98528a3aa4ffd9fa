// The flags that give sizes to the scene's lights.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/image_settings.h"

namespace kindling::app {

class FlagSet;

void add_light_flags(FlagSet& flags, LightOptions& options);

} // namespace kindling::app
