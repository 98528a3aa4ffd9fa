// What path guiding has learned of a scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/bright_patches.h"
#include "renderer/guiding/share_tree.h"

namespace kindling {

struct Guide {
  BrightPatches patches;         // may be empty: directions are not guided
  ShareTree light_probabilities; // may be empty: kinds of light share as LightSet estimates
};

} // namespace kindling
