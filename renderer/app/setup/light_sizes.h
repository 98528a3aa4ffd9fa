// Sizes of the lights of a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/light_options.h"

namespace kindling {
struct Scene;
}

namespace kindling::app {

// Gives sizes to the lights whose file says nothing of theirs; a size of 0 in the file stays.
void apply_light_options(const LightOptions& options, Scene& scene);

} // namespace kindling::app
