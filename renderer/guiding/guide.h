// What path guiding has learned of a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/bright_patches.h"

namespace kindling {

struct Guide {
  BrightPatches patches;
};

} // namespace kindling
