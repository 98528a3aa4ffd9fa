// The learned data of path guiding for one scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/guiding/bright_patches.h"
#include "renderer/guiding/caustic_guide.h"
#include "renderer/guiding/environment_guide.h"
#include "renderer/guiding/light_selection_tree.h"
#include "renderer/guiding/volume_guide.h"

namespace kindling {

struct Guide {
  BrightPatches patches;                  // may be empty: directions are not guided
  LightSelectionTree light_probabilities; // may be empty: LightSet estimates the selection probabilities
  VolumeGuide volumes;                    // may be empty: walks in media follow the phase function
  CausticGuide caustics;                  // may be empty: no caustics were found
  EnvironmentGuide environment;           // may be empty: no directions follow the environment
};

} // namespace kindling
