// Sets the sizes of lights for which the file gives none.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/session/image_settings.h"

namespace kindling {

struct Scene;

// A size in the file is kept, 0 included.
void apply_light_options(const LightOptions& options, Scene& scene);

} // namespace kindling
