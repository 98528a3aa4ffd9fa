// The owner of an EmissionView.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/owned_arrays.h"
#include "renderer/light/emission_view.h"

#include <vector>

namespace kindling {

// Prepares the emission of a set of lights towards targets. `lights` must outlive this. Without
// lights that emit towards a target it is empty().
class EmissionSampling : public EmissionView {
 public:
  EmissionSampling(const LightSetView& lights, std::vector<EmissionTarget> targets, const Box3f& scene_bounds);

 private:
  OwnedArrays arrays_;
};

} // namespace kindling
